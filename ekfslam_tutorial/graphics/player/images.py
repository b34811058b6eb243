"""Images of a camera for the player: small, grey, with what was measured in them."""

from __future__ import annotations

import base64
from io import BytesIO

import numpy as np
from PIL import Image, ImageDraw

from ..style import REJECTED, UPDATED

WIDE = 320
"""No image of a page is wider, pixels."""
QUALITY = 60
ARM = 4
"""Half the size of a mark, pixels."""


def image_of(snapshot) -> str | None:
    """Return what the first camera with an image sees, as the address of a JPEG that is in it; None if there is none.

    Measurements that corrected the map have a square, those that were refused a cross.
    """
    for sen in snapshot.sens:
        image = getattr(snapshot.raw.get(sen.id), "image", None)
        if image is None:
            continue
        picture = Image.fromarray(np.asarray(image, np.uint8)).convert("RGB")
        scale = min(1.0, WIDE / picture.width)
        picture = picture.resize((round(scale * picture.width), round(scale * picture.height)))
        pen = ImageDraw.Draw(picture)
        for (id, _), obs in snapshot.obs.items():
            if id == sen.id and obs.matched and np.isfinite(obs.y).all():
                u, v = ((obs.y[:2] + 0.5) * scale - 0.5).round().astype(int).tolist()
                if obs.updated:
                    pen.rectangle((u - ARM, v - ARM, u + ARM, v + ARM), outline=UPDATED["color"])
                else:
                    pen.line((u - ARM, v - ARM, u + ARM, v + ARM), fill=REJECTED["color"])
                    pen.line((u - ARM, v + ARM, u + ARM, v - ARM), fill=REJECTED["color"])
        file = BytesIO()
        picture.save(file, "JPEG", quality=QUALITY, subsampling=0)  # thin marks keep their colours
        return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()
    return None
