from .planning import plan as plan
from .running import RunResult as RunResult
from .running import run as run
