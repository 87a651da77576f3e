"""What may go wrong, besides ValueError (cannot be meant), OSError (the system refused) and MemoryError."""


class Error(RuntimeError):
    """Of all below."""


class DamagedError(Error):
    """No .ldp file, or one that is damaged or of a newer version."""


class LimitError(Error):
    """Sound, but more than the limits that were given allow."""


class BuildError(Error):
    """`ldp build` could not do it. `status` is its exit status, the text its one line."""

    def __init__(self, message: str, status: int) -> None:
        super().__init__(message)
        self.status = status
