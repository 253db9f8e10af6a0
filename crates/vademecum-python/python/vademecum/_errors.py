"""What can go wrong, by who can act."""

import logging
import warnings


class Error(Exception):
    """Any failure of the package that is not a wrong argument. Its text is that of the program `vademecum`."""


class MachineError(Error, OSError):
    """The machine: disk, memory, permissions."""


class InputError(Error, ValueError):
    """A problem, a scenario, or the value of a live parameter."""


class MeshError(Error, ValueError):
    """A mesh that cannot be read or used."""


class NumericsError(Error, ArithmeticError):
    """A matrix that does not factorise, modes that do not converge."""


class ToleranceMissed(Error):
    """No structure of the built file keeps the tolerance of its problem."""


class FileError(Error, ValueError):
    """A vademecum file that cannot be read, is damaged, or does not have what is asked for."""


class MissingFile(FileError, FileNotFoundError):
    """A vademecum file that is not there."""


class Note(UserWarning):
    """What the program tells as a note about a run, such as a load that acts on nothing."""


def note(text: str, is_warning: bool) -> None:
    """Passes a note of the program on: to the logger `vademecum`, and of a run as a warning, too."""
    logging.getLogger("vademecum").info(text)
    if is_warning:
        warnings.warn(text, Note, stacklevel=4)
