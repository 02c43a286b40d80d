"""A moving picture in three dimensions as a part of a page: it holds its viewer and needs no other file."""

from __future__ import annotations

import base64
import gzip
import html
from dataclasses import dataclass
from typing import ClassVar

# Unpacks the viewer in a frame of its own, whose scripts and styles do not meet the page's.
LOADER = """<!doctype html><meta charset="utf-8"><body><script>
(async () => {
  if (!("DecompressionStream" in window)) {
    document.body.textContent = "This picture needs a browser of 2023 or later.";
    return;
  }
  const packed = Uint8Array.from(atob("%s"), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const text = await new Response(stream).text();
  document.open();
  document.write(text);
  document.close();
})();
</script>"""
# A window that is narrower than the picture shows it smaller, not cut off; the bar of controls hides little.
FITTED = """<style>
  .dg.main .close-button { width: auto !important; position: absolute; right: 0; padding: 0 .8em; background: #1d232999; }
</style>
<script>
  const fit = () => {
    viewer.camera.zoom = Math.min(1, innerWidth / innerHeight / %.6f);
    viewer.camera.updateProjectionMatrix();
    viewer.set_dirty();
  };
  addEventListener("resize", fit);
  addEventListener("load", fit);
</script>
</body>"""
# As wide as the page, unless that would be higher than a window shows at once.
STYLE = "width:min(100%%, 85vh * %.4f);aspect-ratio:%.4f;border:0;display:block;margin:auto"


@dataclass(frozen=True)
class Replay:
    """A viewer with what it plays, which a notebook shows as it is.

    Attributes:
        packed: Its page, compressed, in base64.
        aspect: Width of the picture over its height, on every screen.
        caption: What it shows; also read out in its place.
    """

    packed: str
    aspect: float
    caption: str = "The arm, as it will move: drag to turn it, scroll to come nearer."
    kind: ClassVar[str] = "replay"

    @classmethod
    def of(cls, viewer: str, aspect: float) -> Replay:
        """Of the page of a viewer that was made with Drake's Meshcat."""
        fitted = viewer.replace("</body>", FITTED % aspect)
        content = gzip.compress(fitted.encode("utf-8"), compresslevel=6, mtime=0)
        return cls(base64.b64encode(content).decode("ascii"), aspect)

    @property
    def frame(self) -> str:
        """The frame that shows it, as HTML."""
        inner = html.escape(LOADER % self.packed)
        title = html.escape(self.caption)
        style = STYLE % (self.aspect, self.aspect)
        return f'<iframe srcdoc="{inner}" title="{title}" style="{style}" allowfullscreen></iframe>'

    def _repr_html_(self) -> str:
        return self.frame
