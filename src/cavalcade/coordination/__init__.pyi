from .plan import METHODS as METHODS
from .plan import plan_team as plan_team
from .problem import PlanSettings as PlanSettings
from .problem import TeamProblem as TeamProblem
from .problem import problem_of as problem_of
from .result import TeamPlan as TeamPlan
