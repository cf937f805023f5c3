"""The manual: every link leads somewhere, and pages made from code are current."""

import re
from pathlib import Path

import pytest
from evenspin.api import __all__ as offered
from evenspin.api.reference import pages as api_pages
from evenspin.model.reference import pages as file_pages
from evenspin.model.scenario_schema import event_keys

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("control/**/*.md")])


def anchors(text: str) -> set[str]:
    """As a forge makes them of headings."""
    found: set[str] = set()
    for title in re.findall(r"^#+ +(.*)$", text, re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", title).lower()
        found.add(re.sub(r"[^\w\- ]", "", plain).replace(" ", "-"))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_of_a_page_leads_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    broken = []
    for target in re.findall(r"(?<!`)\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue  # another host
        name, _, place = target.partition("#")
        there = (page.parent / name).resolve() if name else page
        if not there.exists() or (place and place not in anchors(there.read_text(encoding="utf-8"))):
            broken.append(target)

    assert broken == []


@pytest.mark.parametrize("name", ["api.md", "scenario.md"])
def test_a_page_made_from_code_is_current(name):
    made = (api_pages() | file_pages())[name]

    assert (ROOT / "docs" / name).read_text(encoding="utf-8") == made, "run `evenspin docs`"


def test_the_page_of_the_library_has_every_name_and_the_page_of_scenarios_every_key():
    api, scenario = api_pages()["api.md"], file_pages()["scenario.md"]

    assert all(f"`{name}" in api for name in offered)
    assert all(f"| `{key}` |" in scenario for key in event_keys())
