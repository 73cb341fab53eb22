"""Specifications of wrapped environments: where one cannot be written as JSON, the message says why."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from gymnasium.envs.registration import EnvSpec

from ltlc.errors import InvalidArgumentError


class _NoJsonSpec(EnvSpec):
    """The specification of an environment with a wrapper whose arguments are no JSON values."""

    def to_json(self) -> str:
        """Say which argument is in the way."""
        for wrapper in self.additional_wrappers:
            for name, value in (wrapper.kwargs or {}).items():
                if not _is_json(value):
                    raise InvalidArgumentError(
                        f"{wrapper.name} was made with {name}={value!r}, which JSON cannot hold; give labels as the "
                        'text "module:name" of a function that can be imported, and the task as the text of its formula'
                    )
        return super().to_json()


def with_clear_json(spec: EnvSpec | None) -> EnvSpec | None:
    """The same specification; if a wrapper's arguments are no JSON values, its `to_json` names them."""
    if spec is None or all(_is_json(wrapper.kwargs) for wrapper in spec.additional_wrappers):
        return spec
    fields = {field.name: getattr(spec, field.name) for field in dataclasses.fields(spec) if field.init}
    return _NoJsonSpec(**fields)


def _is_json(value: Any) -> bool:
    try:
        json.dumps(value)
    except (TypeError, ValueError):
        return False
    return True
