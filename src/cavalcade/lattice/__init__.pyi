from .ground import Ground as Ground
from .ground import make_ground as make_ground
