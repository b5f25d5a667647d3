from .planner import BodyPlan as BodyPlan
from .planner import plan_body as plan_body
from .settings import BodySettings as BodySettings
from .warming import warm_up as warm_up
