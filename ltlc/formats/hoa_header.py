"""The headers of an HOA automaton: what they say, and whether they fit together."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from ltlc.automata.possible import LetterNumbers, Possible
from ltlc.errors import InvalidArgumentError
from ltlc.formats.edges import letters_of
from ltlc.formats.hoa_acceptance import sets_of
from ltlc.formats.hoa_names import is_misnamed
from ltlc.formats.hoa_parser import Header, HeaderItem, parse_header
from ltlc.formats.hoa_text import HoaText, unquote
from ltlc.ltl.formula import FALSE, Formula

if TYPE_CHECKING:
    from lark import Token

_ONCE = ("states", "aps", "acceptance", "name")


def read_header(text: HoaText, *, nondeterministic: bool = False) -> HoaHeader:
    """The headers of a text.

    Args:
        text: of the automaton.
        nondeterministic: whether it may be.

    Raises:
        HoaSyntaxError: they do not follow the grammar.
        FileFormatError: they contradict each other, or the automaton cannot be read; names line and column.
        AlphabetLimitExceeded: there are too many propositions.
    """
    header = HoaHeader(text, nondeterministic)
    header.read(parse_header(text.text, text.body))
    return header


@dataclass
class HoaHeader:
    """What the headers of an automaton say."""

    text: HoaText
    nondeterministic: bool = False
    """whether the automaton may be nondeterministic."""
    states: Token | None = None
    starts: list[Token] = field(default_factory=list)
    aps: list[str] = field(default_factory=list)
    possible: Possible | None = None
    """which letters are possible; None: all."""
    aliases: dict[str, int] = field(default_factory=dict)
    n_sets: int = 0
    acceptance: Token | None = None
    condition: Formula = FALSE
    name: str | None = None
    finite: bool = False
    """whether the automaton reads finite traces."""
    claims: dict[str, Token] = field(default_factory=dict)
    """properties, with the place of each."""

    def letters(self, expression: Formula, place: Token | int) -> int:
        """The letters of a label; its propositions are numbers, or aliases."""
        n_aps = len(self.aps)

        def atom(name: str) -> int:
            if name.startswith("@"):
                if name not in self.aliases:
                    self.text.fail(place, f"the alias {name} is not defined before it is used")
                return self.aliases[name]
            if len(name) > 10 or int(name) >= n_aps:
                self.text.fail(place, f"there is no proposition {name[:20]}, AP: lists {n_aps}")
            return self.numbers.holding(int(name))

        return letters_of(expression, atom, self.numbers.all)

    @cached_property
    def numbers(self) -> LetterNumbers:
        """The letters over the propositions, of which the header `possible:` may leave out some."""
        return LetterNumbers(tuple(self.aps), self.possible)

    def deny(self, claim: str, place: int, found: str) -> None:
        """Fail if the file claims a property that something in it contradicts."""
        if claim in self.claims:
            line = self.text.line(self.claims[claim].start_pos or 0)
            self.text.fail(place, f"{found}, though line {line} claims `{claim}`; the file is damaged or wrong")

    def read(self, parsed: Header) -> None:
        """Take in what the grammar found."""
        version = parsed.version
        if version != "v1" and not version.startswith("v1."):
            self.text.fail(version, f"this is HOA {version}; only version v1 can be read")
        by_kind: dict[str, list[HeaderItem]] = {}
        for item in parsed.items:
            by_kind.setdefault(item.kind, []).append(item)
            if item.kind in _ONCE and len(by_kind[item.kind]) > 1:
                self.text.fail(item.keyword, f"the header {item.keyword} occurs twice")
            if item.kind == "other" and item.keyword[0].isupper() and item.keyword != "Words:":
                self.text.fail(
                    item.keyword, f"the header {item.keyword} is not known, and it may change what is accepted"
                )
        if "acceptance" not in by_kind:
            self.text.fail(version, "the header Acceptance: is missing")
        # Aliases may be written before the propositions they refer to.
        for kind, read in (
            ("states", self._read_states),
            ("start", self._read_start),
            ("aps", self._read_aps),
            ("other", self._read_possible),
            ("alias", self._read_alias),
            ("acceptance", self._read_acceptance),
            ("name", self._read_name),
            ("properties", self._read_properties),
            ("other", self._read_other),
        ):
            for item in by_kind.get(kind, ()):
                read(item.keyword, *item.values)

    def _read_states(self, _keyword: Token, count: Token) -> None:
        self.text.number(count, count)
        self.states = count

    def _read_start(self, keyword: Token, state: Token, *more: Token) -> None:
        if more:
            self.text.fail(more[0], "universal branching: an alternating automaton is not deterministic")
        if self.starts and not self.nondeterministic:
            self.text.fail(keyword, "a second initial state: the automaton is not deterministic")
        self.text.number(state, state)
        self.starts.append(state)

    def _read_aps(self, _keyword: Token, count: Token, *names: Token) -> None:
        if self.text.number(count, count) != len(names):
            self.text.fail(count, f"AP: announces {count} propositions, and {len(names)} names follow")
        for token in names:
            name = unquote(token)
            if not name:
                self.text.fail(token, "a proposition needs a name")
            if name in self.aps:
                self.text.fail(token, f"the proposition {token} is listed twice")
            self.aps.append(name)

    def _read_possible(self, keyword: Token, *words: Token | None) -> None:
        """A part of the alphabet, written by `ltlc.formats.hoa`: each word the propositions of a combination."""
        if keyword != "possible:":
            return
        part = set()
        for word in words:
            numbers = unquote(word).split() if word is not None and word.startswith('"') else ["?"]
            known = {str(i) for i in range(len(self.aps))}
            if not known.issuperset(numbers):
                self.text.fail(word or keyword, "a combination is a string of numbers of propositions")
            part.add(sum(1 << int(number) for number in set(numbers)))
        parts = (*(self.possible or ()), tuple(sorted(part)))
        try:
            LetterNumbers(tuple(self.aps), parts)
        except InvalidArgumentError:
            self.text.fail(keyword, "a part of the alphabet has combinations, and no proposition of another part")
        self.possible = parts

    def _read_alias(self, _keyword: Token, alias: Token, expression: Formula) -> None:
        if alias in self.aliases:
            self.text.fail(alias, f"the alias {alias} is defined twice")
        self.aliases[str(alias)] = self.letters(expression, alias)

    def _read_acceptance(self, _keyword: Token, count: Token, condition: Formula) -> None:
        self.n_sets = self.text.number(count, count)
        for number, _ in sets_of(condition):
            if number >= self.n_sets:
                self.text.fail(count, f"the condition speaks of set {number}, the number of sets is {count}")
        self.acceptance, self.condition = count, condition

    def _read_name(self, _keyword: Token, name: Token) -> None:
        self.name = unquote(name)

    def _read_properties(self, _keyword: Token, *names: Token) -> None:
        for name in names:
            self.claims.setdefault(str(name), name)

    def _read_other(self, keyword: Token, *words: Token | None) -> None:
        if keyword == "Words:":
            if [str(word) for word in words] != ["finite"]:
                self.text.fail(keyword, "the header Words: says finite, or nothing and is left out")
            self.finite = True
        if keyword == "acc-name:" and words and is_misnamed(self.condition, [str(word) for word in words]):
            name = " ".join(map(str, words))
            self.text.fail(keyword, f"the condition in the header Acceptance: is not what is called {name}")
