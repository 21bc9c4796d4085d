"""Worlds of one's own: a seed for each student of a course."""

import zlib

from freeseg.checks import shown
from freeseg.errors import InvalidParameter


def variant_seed(course: str, student: str) -> int:
    """Seed of the worlds that one student of one course works on.

    Parameters
    ----------
    course, student : str
        Their names; capitals and outer blanks do not count.

    Returns
    -------
    int
        The same for the same names, everywhere.

    Raises
    ------
    InvalidParameter
        For a name that is no text, or empty.

    Examples
    --------
    >>> variant_seed("robotics", "Ada ") == variant_seed("robotics", "ada")
    True
    """
    for whose, name in (("course", course), ("student", student)):
        if not isinstance(name, str) or not name.strip():
            raise InvalidParameter(
                f'{whose} is {shown(name)}; give a name in quotes, such as "ada"'
            )
    return zlib.crc32("\n".join(name.strip().lower() for name in (course, student)).encode())
