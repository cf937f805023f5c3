"""The check of the words finds a private word wherever it stands, and no part of another word."""

from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import check_words as words


def run(files: dict[str, str]) -> tuple[int, str]:
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as out:
        for name, text in files.items():
            (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
            (Path(folder) / name).write_text(text)
        status = words.main(["check_words.py", folder])
    return status, out.getvalue()


class Words(unittest.TestCase):
    def test_a_word_is_found_in_a_comment_a_name_and_a_manual_with_what_to_write(self) -> None:
        status, out = run({"a.c": "\n/* Started anew. */\n", "b/c.py": "news = 1\n", "d.md": "Two Valleys.\n"})
        self.assertEqual(status, 1)
        self.assertEqual(
            sorted(out.splitlines()),
            [
                "a.c:2: anew: write again",
                "b/c.py:1: news: write innovation, events",
                "d.md:1: Valleys: write local minimum",
            ],
        )

    def test_a_part_of_a_word_or_of_a_name_is_none(self) -> None:
        self.assertEqual(run({"a.c": "x.told_apart = newspaper; /* wilderness, desktop */\n"}), (0, ""))

    def test_a_comment_of_a_field_that_goes_on_in_the_next_one_is_found(self) -> None:
        status, out = run({"a.h": "int a; /**< Newest... */\nint b; /**< ...and oldest. */\n/** The same for b. */\n"})
        self.assertEqual((status, [line.split(": ")[0] for line in out.splitlines()]), (1, ["a.h:1", "a.h:2", "a.h:3"]))

    def test_history_and_what_others_wrote_keep_their_words(self) -> None:
        text = "anew\n"
        files = {"CHANGELOG.md": text, "x/vendor/u.js": text, "docs/reference/p.md": text, "a.c": ""}
        self.assertEqual(run(files)[0], 0)

    def test_nothing_to_check_is_an_error(self) -> None:
        self.assertEqual(run({"a.bin": "anew"})[0], 2)


if __name__ == "__main__":
    unittest.main()
