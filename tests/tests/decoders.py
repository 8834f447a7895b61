"""What other people's decoders read from a flight controller's log, in this project's quantities.

Prints a line a reading: quantity, message, time in s, value. Conventions are written out here once more, from the
flight controllers' own documents, so that the readers are held against more than themselves.
"""

import math
import sys


def show(quantity, message, times_s, values):
    for time_s, value in zip(times_s, values):
        print(quantity, message, repr(float(time_s)), repr(float(value)))


def rotation(w, x, y, z):
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if not 0.5 <= norm < 2.0:
        return [math.nan] * 3
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    down_x, down_y, down_z = 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z
    north_x, east_x = w * w + x * x - y * y - z * z, 2 * (x * y + w * z)
    pitch = math.asin(max(-1.0, min(1.0, -down_x)))
    return [math.atan2(down_y, down_z), pitch, math.atan2(east_x, north_x)]


def px4(path):
    from pyulog import ULog

    log = ULog(path)
    topics = {topic.name: topic.data for topic in log.data_list if topic.multi_id == 0}
    parameter = dict(log.initial_parameters)
    parameter.update({name: value for _, name, value in log.changed_parameters})

    def seconds(data, sampled=True):
        has = sampled and "timestamp_sample" in data and all(stamp > 0 for stamp in data["timestamp_sample"])
        return [int(stamp) * 1e-6 for stamp in data["timestamp_sample" if has else "timestamp"]]

    axes = [("p_rad_s", "ax_m_s2"), ("q_rad_s", "ay_m_s2"), ("r_rad_s", "az_m_s2")]
    for topic, fields in [
        ("vehicle_angular_velocity", ["xyz[0]", "xyz[1]", "xyz[2]"]),
        ("sensor_combined", ["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"]),
        ("vehicle_attitude", ["rollspeed", "pitchspeed", "yawspeed"]),
    ]:
        data = topics.get(topic, {})
        if fields[0] in data:
            for (rate, _), field in zip(axes, fields):
                show(rate, topic, seconds(data), data[field])
    data = topics.get("sensor_combined", {})
    if "accelerometer_m_s2[0]" in data:
        later = data["accelerometer_timestamp_relative"]
        there = [row for row in range(len(later)) if abs(int(later[row])) < 2147483647]
        times_s = [(int(data["timestamp"][row]) + int(later[row])) * 1e-6 for row in there]
        for place, (_, force) in enumerate(axes):
            show(force, "sensor_combined", times_s, [data[f"accelerometer_m_s2[{place}]"][row] for row in there])
    data = topics.get("vehicle_attitude", {})
    if data:
        parts = [[float(value) for value in data[f"q[{i}]"]] for i in range(4)]
        angles = [rotation(*row) for row in zip(*parts)]
        for place, name in enumerate(["roll_rad", "pitch_rad", "yaw_rad"]):
            show(name, "vehicle_attitude", seconds(data), [row[place] for row in angles])
    data = topics.get("vehicle_attitude_setpoint", {})
    for name, field in [("roll", "roll_body"), ("pitch", "pitch_body"), ("yaw", "yaw_body")]:
        if field in data:
            show(f"{name}_ref_rad", "vehicle_attitude_setpoint", seconds(data, False), data[field])
    data = topics.get("manual_control_setpoint", {})
    for name, fields, sign in [("roll", ["roll", "y"], 1), ("pitch", ["pitch", "x"], -1), ("yaw", ["yaw", "r"], 1)]:
        for field in [field for field in fields if field in data][:1]:
            values = [sign * float(value) for value in data[field]]
            show(f"{name}_stick", "manual_control_setpoint", seconds(data, False), values)
    if "actuator_motors" in topics:
        data = topics["actuator_motors"]
        for motor in range(4):
            values = [float(value) for value in data[f"control[{motor}]"]]
            values = [0.0 if math.isnan(value) else max(value, 0.0) for value in values]
            show(f"motor{motor + 1}", "actuator_motors", seconds(data, False), values)
    elif "actuator_outputs" in topics:
        data = topics["actuator_outputs"]
        for motor in range(4):
            least = parameter.get(f"PWM_MAIN_MIN{motor + 1}", -1)
            most = parameter.get(f"PWM_MAIN_MAX{motor + 1}", -1)
            least = least if least >= 0 else parameter.get("PWM_MAIN_MIN", parameter.get("PWM_MIN", 1000))
            most = most if most >= 0 else parameter.get("PWM_MAIN_MAX", parameter.get("PWM_MAX", 2000))
            values = [(float(us) - least) / (most - least) for us in data[f"output[{motor}]"]]
            values = [max(0.0, min(1.0, value)) for value in values]
            show(f"motor{motor + 1}", "actuator_outputs", seconds(data, False), values)
    data = topics.get("actuator_controls_0", {})
    if data:
        for place, name in enumerate(["roll_cmd", "pitch_cmd", "yaw_cmd", "thrust_cmd"]):
            show(name, "actuator_controls_0", seconds(data, False), data[f"control[{place}]"])
    data = topics.get("vehicle_local_position", {})
    if data:
        for name, field, flag, sign in [
            ("vn_m_s", "vx", "v_xy_valid", 1), ("ve_m_s", "vy", "v_xy_valid", 1),
            ("vd_m_s", "vz", "v_z_valid", 1), ("height_m", "z", "z_valid", -1),
        ]:
            valid = data.get(flag, [1] * len(data[field]))
            values = [sign * float(value) if is_valid else math.nan for value, is_valid in zip(data[field], valid)]
            show(name, "vehicle_local_position", seconds(data), values)
    data = topics.get("battery_status", {})
    if data:
        show("battery_v", "battery_status", seconds(data), data["voltage_v"])


def ardupilot(path):
    from pymavlink import DFReader

    reader = DFReader.DFReader_binary(path)
    messages, parameter = {}, {}
    while True:
        message = reader.recv_msg()
        if message is None:
            break
        if message.get_type() == "PARM":
            parameter[message.Name] = message.Value
        messages.setdefault(message.get_type(), []).append(message)

    def readings(kind, name, field, change):
        found = [message for message in messages.get(kind, []) if getattr(message, "I", 0) == 0]
        times_s = [m.TimeUS * 1e-6 if hasattr(m, "TimeUS") else m.TimeMS * 1e-3 for m in found]
        show(name, kind, times_s, [change(getattr(message, field)) for message in found])

    def angle(degrees):
        return math.remainder(math.radians(degrees), math.tau)

    for axis, rate, force in [("X", "p", "ax"), ("Y", "q", "ay"), ("Z", "r", "az")]:
        readings("IMU", f"{rate}_rad_s", f"Gyr{axis}", float)
        readings("IMU", f"{force}_m_s2", f"Acc{axis}", float)
    for name in ["Roll", "Pitch", "Yaw"]:
        readings("ATT", f"{name.lower()}_rad", name, angle)
        readings("ATT", f"{name.lower()}_ref_rad", f"Des{name}", angle)
    for axis, usual in [("roll", 1), ("pitch", 2), ("yaw", 4)]:
        channel = int(parameter.get(f"RCMAP_{axis.upper()}", usual))
        turned = parameter.get(f"RC{channel}_REVERSED", 0) == 1 or parameter.get(f"RC{channel}_REV", 1) == -1
        sign = -1 if turned else 1
        if "RCIN" in messages:
            readings("RCIN", f"{axis}_stick", f"C{channel}",
                     lambda us: max(-1.0, min(1.0, sign * (us - 1500.0) / 500.0)))
    least = parameter.get("MOT_PWM_MIN", 0) or parameter.get("RC3_MIN", 1000)
    most = parameter.get("MOT_PWM_MAX", 0) or parameter.get("RC3_MAX", 2000)
    field = "C{}" if hasattr(messages["RCOU"][0], "C1") else "Ch{}"
    for motor in range(1, 5):
        readings("RCOU", f"motor{motor}", field.format(motor),
                 lambda us: max(0.0, min(1.0, (us - least) / (most - least))))
    readings("CURR", "battery_v", "Volt", lambda volts: 0.01 * volts)
    for name, field in [("vn_m_s", "VN"), ("ve_m_s", "VE"), ("vd_m_s", "VD")]:
        readings("EKF1", name, field, float)
    readings("EKF1", "height_m", "PD", lambda down: -down)


{"px4": px4, "ardupilot": ardupilot}[sys.argv[1]](sys.argv[2])
