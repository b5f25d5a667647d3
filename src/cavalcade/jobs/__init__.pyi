from .live_folder import finish_recording as finish_recording
from .live_folder import record_live as record_live
from .running import JobResult as JobResult
from .running import plan as plan
from .running import run as run
