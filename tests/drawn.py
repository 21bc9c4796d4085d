"""What the tests of pictures share."""


def texts(ax):
    """All that is written in axes, but for labels and titles."""
    return [text.get_text() for text in ax.texts if text.get_text()]
