"""The vendor's message types and the DDS they travel by, loaded when they are needed."""

from __future__ import annotations

import importlib
from typing import Any

from cavalcade.errors import InputError
from cavalcade.fleet.unitree.octets import announce_as_octets

_HOW = "pip install 'cavalcade[unitree]'"

LOOPBACK = ("lo", "lo0")
"""Interfaces that know no multicast: peers are looked for one by one."""

REQUESTS = "rt/api/sport/request"
RESPONSES = "rt/api/sport/response"
SPORT_STATE = "rt/sportmodestate"
LOW_STATE = "rt/lowstate"


class Sdk:
    """The classes of the vendor's messages that are used here.

    Raises:
        InputError: They are not there or do not load; the line says how to get them.
    """

    def __init__(self) -> None:
        try:
            importlib.import_module("cyclonedds.domain")
            self._api = importlib.import_module("unitree_sdk2py.idl.unitree_api.msg.dds_")
            self._default = importlib.import_module("unitree_sdk2py.idl.default")
        except ImportError as error:
            raise InputError(
                f"the SDK of Unitree cannot be loaded ({error}): {_HOW}", key="unitree"
            ) from None
        self.request_type: Any = self._api.Request_
        self.response_type: Any = self._api.Response_
        self.sport_state_type: Any = type(self.sport_state())
        self.low_state_type: Any = type(self.low_state())

    def request(self, number: int, api: int, parameter: str, no_reply: bool) -> Any:
        """A request of a service."""
        api_types = self._api
        header = api_types.RequestHeader_(
            api_types.RequestIdentity_(number, api),
            api_types.RequestLease_(0),
            api_types.RequestPolicy_(0, no_reply),
        )
        return self.request_type(header, parameter, [])

    def response(self, number: int, api: int, code: int) -> Any:
        """The answer to a request."""
        api_types = self._api
        header = api_types.ResponseHeader_(
            api_types.RequestIdentity_(number, api), api_types.ResponseStatus_(code)
        )
        return self.response_type(header, "", [])

    def sport_state(self) -> Any:
        """Where a robot is and what it does, with zeros."""
        return self._default.unitree_go_msg_dds__SportModeState_()

    def low_state(self) -> Any:
        """Its battery, among much else, with zeros."""
        return self._default.unitree_go_msg_dds__LowState_()


def load_sdk() -> Sdk:
    """The vendor's message types.

    Raises:
        InputError: They are not there or do not load; the line says how to get them.
    """
    return Sdk()


class Network:
    """A participant in one DDS domain on one network interface.

    Close it, or let the process end, before another one of the same domain is made.

    Args:
        domain: Number of the DDS domain; robots as they are delivered are in 0.
        interface: Name of the network interface, empty for the one that the system prefers.

    Raises:
        InputError: There is no such interface, or the domain cannot be used.
    """

    def __init__(self, domain: int, interface: str = "") -> None:
        from cyclonedds.core import DDSException
        from cyclonedds.domain import Domain, DomainParticipant

        try:
            self._domain = Domain(domain, _configuration(interface))
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            where = f"interface {interface!r}" if interface else "any interface"
            text = f"domain {domain} cannot be joined on {where}: is it there and up? ({error})"
            raise InputError(text, key="unitree") from None

    def writer(self, topic: str, kind: Any) -> Any:
        """A writer that never waits: who does not listen misses a message."""
        from cyclonedds.pub import DataWriter

        return DataWriter(self._participant, self._topic(topic, kind), self._reliable())

    def reader(
        self,
        topic: str,
        kind: Any,
        depth: int = 1,
        *,
        reliable: bool = False,
        others: bool = False,
    ) -> Any:
        """A reader that keeps the newest `depth` messages until they are taken.

        With `others`, messages of this participant itself are left out.
        """
        from cyclonedds.core import Policy, Qos
        from cyclonedds.sub import DataReader

        qos = self._reliable() if reliable else Qos(Policy.Reliability.BestEffort)
        qos = Qos(Policy.History.KeepLast(depth), base=qos)
        if others:
            qos = Qos(Policy.IgnoreLocal.Participant, base=qos)
        return DataReader(self._participant, self._topic(topic, kind), qos)

    def _topic(self, name: str, kind: Any) -> Any:
        from cyclonedds.topic import Topic

        announce_as_octets(kind)
        return Topic(self._participant, name, kind)

    def _reliable(self) -> Any:
        from cyclonedds.core import Policy, Qos

        # The least time that a writer can be told to wait for one that does not confirm, ns.
        return Qos(Policy.Reliability.Reliable(1), Policy.History.KeepLast(1))


def take(reader: Any, most: int = 1) -> list[Any]:
    """The messages that wait, oldest first; what is no whole message is left out."""
    from cyclonedds.core import DDSException
    from cyclonedds.internal import InvalidSample

    try:
        samples = reader.take(most)
    except DDSException:
        return []
    return [sample for sample in samples if not isinstance(sample, InvalidSample)]


def write(writer: Any, message: Any) -> None:
    """Send a message if that is possible now."""
    from cyclonedds.core import DDSException

    try:
        writer.write(message)
    except DDSException:
        return  # what is not answered is noticed and sent again


def _configuration(interface: str) -> str:
    chosen = f'name="{interface}"' if interface else 'autodetermine="true"'
    local = ""
    if interface in LOOPBACK:
        local = (
            "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
        )
    return (
        f"<CycloneDDS><Domain Id='any'><General><Interfaces><NetworkInterface {chosen}/>"
        f"</Interfaces></General>{local}</Domain></CycloneDDS>"
    )
