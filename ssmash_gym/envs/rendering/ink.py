"""Text on surfaces, with the drawn words kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from ssmash_gym.envs.rendering.palette import Colour

if TYPE_CHECKING:
    import pygame

FINENESS: Final = 3  # words are drawn this many times larger and then smoothed: small letters keep their spacing
KEPT: Final = 600  # drawn words; numbers change all the time, so old ones must go


class Ink:
    """Writes with pygame's own font and remembers what it has drawn.

    Args:
        height_px: Height of the ordinary text; small text is about six sevenths of it.
    """

    def __init__(self, height_px: int) -> None:
        import pygame

        pygame.font.init()
        self.height = height_px
        self._fonts = {size: pygame.font.Font(None, FINENESS * size) for size in (height_px, self.small, self.large)}
        self._kept: dict[tuple[str, Colour, int], pygame.Surface] = {}

    @property
    def small(self) -> int:
        """Height of small text [px]."""
        return max(13, round(0.86 * self.height))

    @property
    def large(self) -> int:
        """Height of large text [px]."""
        return round(1.55 * self.height)

    def word(self, text: str, colour: Colour, size: int | None = None) -> pygame.Surface:
        """The text as a surface."""
        key = (text, colour, size or self.height)
        found = self._kept.get(key)
        if found is None:
            if len(self._kept) >= KEPT:
                self._kept.clear()
            found = self._kept[key] = self._smooth(self._fonts[key[2]].render(text, True, colour))
        return found

    @staticmethod
    def _smooth(word: pygame.Surface) -> pygame.Surface:
        import pygame

        width, height = word.get_size()
        return pygame.transform.smoothscale(word, (max(1, width // FINENESS), max(1, height // FINENESS)))

    def write(
        self,
        surface: pygame.Surface,
        text: str,
        place: tuple[float, float],
        colour: Colour,
        size: int | None = None,
        align: float = 0.0,
    ) -> int:
        """Write with the upper edge at `place`; `align` 0 starts there, 1 ends there, 0.5 is centred. Width [px]."""
        word = self.word(text, colour, size)
        width: int = word.get_width()
        surface.blit(word, (round(place[0] - align * width), round(place[1])))
        return width
