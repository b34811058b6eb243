"""Images as measurements: where they come from, what a landmark looks like, and how it is found again.

Lives here: pictures and their sources, beside the simulator and recordings; `ActiveSearch`, an association that
measures on demand; appearances of landmarks, set at birth and warped to be found; a target of known size.
May not: be needed by a run without images. OpenCV is an extra, imported when the first image is looked at.
"""

from .picture import Picture
from .search import ActiveSearch
from .sources import Pictures

__all__ = ["ActiveSearch", "Picture", "Pictures"]
