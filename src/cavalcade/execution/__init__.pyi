from .control import ControlLoop as ControlLoop
from .loop import carry_out as carry_out
from .policy import Policy as Policy
from .policy import Reconfigurable as Reconfigurable
