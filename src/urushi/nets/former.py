"""Detection of networks of earlier versions, whose codes had no analytic lobe (`urushi.nets.lobe`).

Their names, their weights, and the materials and textures made with them are recognised and
refused.
"""

from urushi.errors import FileError

#: The version that reads them.
VERSION = "Urushi 0.1.0 of commit 3078021"

#: The last of them: names by fingerprint.
NAMES = {"18db0cb6471c": "base", "670684d2b9d0": "small"}


def refuse_name(name: str) -> None:
    """Refuse a name of shipped weights.

    Raises:
        FileError: it is that of former ones.
    """
    if name in NAMES.values():
        raise FileError(
            f"the weights '{name}' are no longer shipped; use 'default', or {VERSION}, which has "
            "them"
        )


def refuse_weights(path: object, architecture: object) -> None:
    """Refuse a weights file by its entry `architecture`.

    Raises:
        FileError: the codes of its networks have no lobe.
    """
    if isinstance(architecture, dict) and "latent" in architecture and "lobe" not in architecture:
        raise FileError(
            f"'{path}' holds networks whose codes have no analytic lobe; {VERSION} reads it, or "
            "train the networks again"
        )


def refuse_codes(path: object, made_with: object) -> None:
    """Refuse a material's or texture's file by the fingerprint of the weights that made it.

    Raises:
        FileError: these are former ones.
    """
    name = NAMES.get(str(made_with))
    if name is not None:
        raise FileError(
            f"'{path}' was made with the former weights '{name}'; {VERSION} reads it, or create it "
            "again from its source"
        )
