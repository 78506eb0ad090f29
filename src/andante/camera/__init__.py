"""Image and geometry in, panorama out: fisheye models, the image circle, rays and the unwrapping table."""

from andante.camera.circle import MIN_CONFIDENCE as MIN_CONFIDENCE
from andante.camera.circle import ImageCircle as ImageCircle
from andante.camera.circle import find_image_circle as find_image_circle
from andante.camera.circle import with_found_circle as with_found_circle
from andante.camera.models import Equidistant as Equidistant
from andante.camera.models import Equisolid as Equisolid
from andante.camera.models import FisheyeModel as FisheyeModel
from andante.camera.models import KannalaBrandt as KannalaBrandt
from andante.camera.models import OCam as OCam
from andante.camera.models import Stereographic as Stereographic
from andante.camera.models import fisheye_model as fisheye_model
from andante.camera.rays import project as project
from andante.camera.rays import rays as rays
from andante.camera.rays import rays_of_pixels as rays_of_pixels
from andante.camera.rays import scaled as scaled
from andante.camera.unwrap import FisheyeTable as FisheyeTable
from andante.camera.unwrap import PanoramaGeometry as PanoramaGeometry
from andante.camera.unwrap import Shrinking as Shrinking
from andante.camera.unwrap import Unwrapper as Unwrapper
