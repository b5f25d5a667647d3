"""A program that drives Go2s until somebody kills it: DOMAIN... [--damp]."""

import sys

from cavalcade.fleet.unitree import Go2Fleet, Go2Link

domains = [int(word) for word in sys.argv[1:] if word.isdigit()]
fleet = Go2Fleet(
    [Go2Link(domain, "lo", offset=(0.0, 0.0, 0.0)) for domain in domains],
    silence="damp" if "--damp" in sys.argv else "stop",
)
fleet.start(60.0)
while True:
    fleet.send([(0.4, 0.0, 0.0)] * len(domains))
    fleet.advance(0.05)
