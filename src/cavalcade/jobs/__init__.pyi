from .running import JobResult as JobResult
from .running import plan as plan
from .running import run as run
