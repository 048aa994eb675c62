"""Names that a type checker must refuse: mypy reports comments on lines that have no error."""

import urushi

print(urushi.encode)
print(urushi.nothing)  # type: ignore[attr-defined]
