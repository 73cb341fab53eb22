"""`ltlc doctor`: what works here."""

from __future__ import annotations

import json

from ltlc.cli import flags


def doctor(json_: flags.Json = False) -> int:
    """Say what of ltlc works here, and what to install for the rest.

    Every package that it uses is imported once, which takes some seconds. The
    exit code is 1 where something that is needed does not work; extras and
    programs that are missing are none of that.

    \b
    Examples:
      ltlc doctor
      ltlc doctor --json
    """
    from ltlc.doctor import examine

    health = examine()
    if json_:
        print(json.dumps(health.to_dict(), ensure_ascii=False, indent=2))
    else:
        print(
            f"ltlc {health.version}{' (compiled)' if health.compiled else ''}, Python {health.python}, {health.system}"
        )
        print(f"networks train on: {', '.join(health.devices) or 'nothing, because torch does not work'}")
        for kind, title in (("needed", "needed"), ("extra", "extras"), ("program", "programs")):
            print(f"\n{title}:")
            for one in [finding for finding in health.findings if finding.kind == kind]:
                purpose = f"  for {one.purpose}" if kind != "needed" else ""
                print(f"  {one.state:8}{one.name:20}{one.version or '':14}{purpose}".rstrip())
                if one.advice:
                    print(f"          {one.advice}")
        print(f"\n{'What is needed works.' if health.works else 'Something that is needed does not work; see above.'}")
    return 0 if health.works else 1
