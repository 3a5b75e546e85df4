# SPDX-License-Identifier: Apache-2.0
"""The table of fields in gripper_files.md, from the code: python docs/field_table.py writes it."""

import re
from pathlib import Path

from spiral_gripper.files.fields import FIELDS, LAWS, Field, constants_of

PAGE = Path(__file__).parent / "gripper_files.md"
# The table is what lies between these lines of the page.
BLOCK = re.compile(r"(?<=<!-- fields -->\n).*?(?=<!-- end -->)", re.DOTALL)


def field_table() -> str:
    """Return the table in Markdown, a line for each field."""
    head = "| field | kind | required | allowed | if left out |\n|---|---|---|---|---|\n"
    return head + "".join(_row(name, field) for name, field in FIELDS.items())


def _row(name: str, field: Field) -> str:
    by_law = {f"material.{constant}" for law in LAWS for constant in constants_of(law)}
    required = "by the law" if name in by_law else "yes" if field.required else "no"
    return (
        f"| `{name}` | {field.kind} | {required} | {field.allowed} | {field.default} |".replace(
            "|  |", "| |"
        )
        + "\n"
    )


if __name__ == "__main__":
    PAGE.write_text(BLOCK.sub(lambda _: field_table(), PAGE.read_text("utf-8")), "utf-8")
