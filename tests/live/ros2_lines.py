"""The lines of `ros2` that the documentation shows, carried out with rclpy: wheels lack `ros2`."""

from __future__ import annotations

import argparse
import time as wall
from typing import Any

import yaml

from cavalcade.fleet.ros2 import Graph, message_type, qos

_PATIENCE = 30.0


def carry_out(graph: Graph, words: list[str]) -> Any:
    """`ros2 topic pub --once`, `ros2 topic echo --once` or `ros2 service call`.

    Returns:
        Nothing, the message that was heard, or the service's answer.
    """
    act = {("topic", "pub"): _publish, ("topic", "echo"): _echo, ("service", "call"): _call}
    return act[words[1], words[2]](graph, words[3:])


def _publish(graph: Graph, words: list[str]) -> None:
    parser = argparse.ArgumentParser(exit_on_error=False)
    parser.add_argument("--once", action="store_true", required=True)
    for name in ("topic", "type", "values"):
        parser.add_argument(name)
    said = parser.parse_args(words)
    message = message_type(said.type)()
    fill(message, yaml.safe_load(said.values))
    publisher = graph.publisher(said.type, said.topic, qos.reliable())
    _until(lambda: publisher.get_subscription_count() > 0, f"{said.topic}: nobody listens")
    publisher.publish(message)
    graph.deliver(publisher)
    graph.node.destroy_publisher(publisher)


def _echo(graph: Graph, words: list[str]) -> Any:
    parser = argparse.ArgumentParser(exit_on_error=False)
    parser.add_argument("--once", action="store_true", required=True)
    parser.add_argument("--field")
    parser.add_argument("topic")
    said = parser.parse_args(words)
    _until(lambda: graph.node.count_publishers(said.topic) > 0, f"{said.topic}: nobody publishes")
    end = graph.node.get_publishers_info_by_topic(said.topic)[0]
    heard: list[Any] = []
    waits = end.qos_profile.durability.name == "TRANSIENT_LOCAL"
    quality = qos.latched() if waits else qos.sensor_data()
    listener = graph.subscribe(end.topic_type, said.topic, heard.append, quality)
    _until(lambda: heard, f"{said.topic}: nothing was heard")
    graph.node.destroy_subscription(listener)
    return getattr(heard[0], said.field) if said.field else heard[0]


def _call(graph: Graph, words: list[str]) -> Any:
    name, kind, *values = words
    service = message_type(kind)
    request = service.Request()
    fill(request, yaml.safe_load(values[0]) if values else {})
    client = graph.node.create_client(service, name)
    _until(client.service_is_ready, f"{name}: there is no such service")
    answer = client.call_async(request)
    _until(answer.done, f"{name}: no answer")
    graph.node.destroy_client(client)
    return answer.result()


def fill(message: Any, values: dict[str, Any]) -> None:
    """Set a message's fields as `ros2` does it; a field that there is not is an error."""
    types = message.get_fields_and_field_types()
    for key, value in values.items():
        kind = types[key]
        if isinstance(value, dict):
            fill(getattr(message, key), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            package, name = kind.removeprefix("sequence<").rstrip(">").split("/")
            element = message_type(f"{package}/msg/{name}")
            parts = [element() for _ in value]
            for part, one in zip(parts, value, strict=True):
                fill(part, one)
            setattr(message, key, parts)
        else:
            held = getattr(message, key)
            setattr(message, key, float(value) if isinstance(held, float) else value)


def _until(condition: Any, otherwise: str) -> None:
    end = wall.monotonic() + _PATIENCE
    while not condition():
        if wall.monotonic() > end:
            raise AssertionError(otherwise)
        wall.sleep(0.02)
