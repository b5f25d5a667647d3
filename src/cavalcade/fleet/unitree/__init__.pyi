from .fleet import Go2Fleet as Go2Fleet
from .link import Go2Link as Go2Link
from .sdk import load_sdk as load_sdk
