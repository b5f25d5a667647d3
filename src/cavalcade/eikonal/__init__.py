"""Arrival times by fast marching, velocity maps and the paths down them."""

from cavalcade.eikonal.field import ArrivalField, TravelGrid, arrival_times
from cavalcade.eikonal.velocity import surface_distance, velocity_map

__all__ = ["ArrivalField", "TravelGrid", "arrival_times", "surface_distance", "velocity_map"]
