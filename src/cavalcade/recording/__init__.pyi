from .frames import Frame as Frame
from .frames import ObstacleTrack as ObstacleTrack
from .frames import Recording as Recording
from .mcap_reader import read_recording as read_recording
from .mcap_writer import write_recording as write_recording
from .plan_file import read_plan as read_plan
from .plan_file import write_plan as write_plan
from .status import PlannerStatus as PlannerStatus
