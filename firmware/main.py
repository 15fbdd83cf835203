"""Starts by itself; with the service pin tied to ground it leaves the board to its programmer."""

import machine
import settings
from pico import PicoIO
from station import Station


def main():
    """Be a rig's device for ever; after an error, from the start: with the air out."""
    station = Station(PicoIO(settings), settings)
    try:
        while True:
            station.step()
    finally:
        machine.reset()


if machine.Pin(settings.SERVICE_PIN, machine.Pin.IN, machine.Pin.PULL_UP).value():
    main()
