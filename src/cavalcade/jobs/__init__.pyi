from .planning import plan as plan
from .result import JobResult as JobResult
from .running import run as run
