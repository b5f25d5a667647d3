from .control import ControlLoop as ControlLoop
from .control import Planner as Planner
from .progress import Progress as Progress
from .progress import ProgressSink as ProgressSink
from .simulation import simulate as simulate
