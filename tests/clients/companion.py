"""MAVSDK as a companion computer: attitude, parameters, arming, an attitude set-point, disarming."""

import asyncio
import sys

from mavsdk import System
from mavsdk.offboard import Attitude, OffboardError
from mavsdk.telemetry import FlightMode

from served import Served, Stopwatch, expect


async def first(stream, so=lambda value: True, patience_s=10.0):
    async def search():
        async for value in stream:
            if so(value):
                return value
    return await asyncio.wait_for(search(), patience_s)


async def fly(port, watch):
    drone = System()
    await drone.connect(system_address=f"tcpout://127.0.0.1:{port}")
    await first(drone.core.connection_state(), lambda state: state.is_connected)
    watch.lap("connected")
    attitude = await first(drone.telemetry.attitude_euler())
    expect(abs(attitude.roll_deg) < 1 and abs(attitude.pitch_deg) < 1, f"level: {attitude}")
    watch.lap("attitude")
    everything = await drone.param.get_all_params()
    named = {parameter.name: parameter.value for parameter in everything.float_params}
    expect(len(named) > 70 and "CONTROLLER" in named, f"{len(named)} parameters")
    watch.lap(f"{len(named)} parameters")
    await drone.param.set_param_float("PILOT_TILT_DEG", 25.0)
    expect(await drone.param.get_param_float("PILOT_TILT_DEG") == 25.0, "the parameter that was set")
    watch.lap("a parameter set and read")
    await first(drone.telemetry.health(), lambda health: health.is_armable)
    watch.lap("armable")
    await drone.action.arm()
    watch.lap("armed")
    try:
        await drone.offboard.start()
        expect(False, "no offboard without set-points")
    except OffboardError:
        pass
    await drone.offboard.set_attitude(Attitude(0.0, 0.0, 0.0, 0.0))
    await drone.offboard.start()
    mode = await first(drone.telemetry.flight_mode(), lambda mode: mode == FlightMode.OFFBOARD)
    watch.lap(f"mode {mode}")
    await drone.offboard.set_attitude(Attitude(10.0, -5.0, 0.0, 0.5))

    def there(now):
        return abs(now.roll_deg - 10.0) < 1.0 and abs(now.pitch_deg + 5.0) < 1.0
    found = await first(drone.telemetry.attitude_euler(), there)
    await asyncio.sleep(1)
    held = await first(drone.telemetry.attitude_euler())
    expect(there(held), f"10 and -5 degrees are held: {held}")
    watch.lap(f"flies {found.roll_deg:.1f} and {found.pitch_deg:.1f} degrees")
    await drone.offboard.set_attitude(Attitude(0.0, 0.0, 0.0, 0.5))
    await first(drone.telemetry.attitude_euler(), lambda now: abs(now.roll_deg) < 1.0 and abs(now.pitch_deg) < 1.0)
    await drone.action.disarm()
    await first(drone.telemetry.armed(), lambda armed: not armed)
    watch.lap("level, disarmed")


def main():
    for controller in ["pid", "mpc"]:
        with Served(sys.argv[1], "--rig", "gimbal", "--controller", controller) as served:
            print(f"  {controller}")
            asyncio.run(fly(served.port, Stopwatch()))


if __name__ == "__main__":
    main()
