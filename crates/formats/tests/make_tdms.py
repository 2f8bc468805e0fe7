"""Writes the fixtures of TDMS files, and what npTDMS reads from them.

npTDMS 1.13.0, numpy 2.4.6: `python make_tdms.py` in this folder.

npTDMS writes contiguous little-endian segments that describe all their objects. Other segments are put
together here, by NI's description of the format.
"""
import json, os, struct
import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "tdms")
os.makedirs(here, exist_ok=True)
random = np.random.default_rng(7)
expected = {}
META, LIST, RAW, INTERLEAVED, BIG, DAQMX = 2, 4, 8, 32, 64, 128

def hexed(array):
    return np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes().hex()

def read(name):
    """What npTDMS reads."""
    path = os.path.join(here, name)
    file = TdmsFile.read(path, raw_timestamps=True)
    found = {}
    for group in file.groups():
        for channel in group.channels():
            one = found[f"{group.name}/{channel.name}"] = {}
            p = channel.properties
            if "wf_increment" in p:
                one["even"] = [p["wf_start_offset"], p["wf_increment"]]
            try:
                data = channel[:]
            except Exception:
                continue
            if len(data) and hasattr(data, "second_fractions"):
                seconds = [int(s) - 2082844800 for s in data.seconds]
                fractions = [int(f) for f in data.second_fractions]
                times = [s * 10**9 + ((f * 10**9 + (1 << 63)) >> 64) for s, f in zip(seconds, fractions)]
                # npTDMS cuts what this rounds.
                cut = data.as_datetime64("ns").astype(np.int64)
                assert all(0 <= a - b <= 1 for a, b in zip(times, cut.tolist()))
                one.update(type="i8", shape=[len(times)], hex=hexed(np.array(times, "i8")))
            elif data.dtype.kind == "O":
                one["text"] = list(data)
            elif data.dtype.kind not in "cV":
                # Scaled.
                one.update(type=data.dtype.kind + str(data.dtype.itemsize), shape=[len(data)], decoded=hexed(data))
    expected[name] = found

def write(name, objects, *more):
    with TdmsWriter(os.path.join(here, name)) as writer:
        for segment in (objects, *more):
            writer.write_segment(segment)
    read(name)

def text(order, s):
    s = s.encode()
    return struct.pack(order + "I", len(s)) + s

def properties(order, values):
    out = struct.pack(order + "I", len(values))
    for key, value in values.items():
        out += text(order, key)
        if isinstance(value, str):
            out += struct.pack(order + "I", 0x20) + text(order, value)
        elif isinstance(value, int):
            out += struct.pack(order + "Ii", 3, value)
        elif isinstance(value, tuple):
            seconds, fraction = value
            parts = (fraction, seconds) if order == "<" else (seconds, fraction)
            out += struct.pack(order + "I" + ("Qq" if order == "<" else "qQ"), 0x44, *parts)
        else:
            out += struct.pack(order + "Id", 10, value)
    return out

def obj(path, index=None, values={}, order="<"):
    """`index`: None without samples, "same", bytes, or type and number of values."""
    if index is None:
        raw = struct.pack(order + "I", 0xFFFFFFFF)
    elif index == "same":
        raw = struct.pack(order + "I", 0)
    elif isinstance(index, bytes):
        raw = index
    else:
        kind, count, *size = index
        raw = struct.pack(order + "IIIQ", 20 + 8 * len(size), kind, 1, count)
        raw += b"".join(struct.pack(order + "Q", s) for s in size)
    return text(order, path) + raw + properties(order, values)

def segment(toc, objects, data=b"", length=None):
    order = ">" if toc & BIG else "<"
    meta = struct.pack(order + "I", len(objects)) + b"".join(objects) if toc & META else b""
    length = len(meta) + len(data) if length is None else length
    return b"TDSm" + struct.pack("<I", toc) + struct.pack(order + "IQQ", 4713, length, len(meta)) + meta + data

def raw(name, *segments):
    with open(os.path.join(here, name), "wb") as f:
        f.write(b"".join(segments))
    read(name)

def ch(name, group="g"):
    return f"/'{group}'/'{name}'"

def i16(n):
    return random.integers(-2**15, 2**15, n, dtype=np.int16)

def of(kind, n):
    return np.frombuffer(random.bytes(n * np.dtype(kind).itemsize), kind)

# All types.
numbers = [ChannelObject("types", k, of(k, 7)) for k in
           "int8 int16 int32 int64 uint8 uint16 uint32 uint64".split()]
numbers += [ChannelObject("types", k, random.standard_normal(7).astype(k)) for k in ("float32", "float64")]
# Before 1970 too, and with a fraction.
times = np.array(["2026-01-01T00:00:00.000001", "1950-06-01", "1904-01-01T00:00:01.5", "2000-02-29T12:34:56.999999"],
                 dtype="datetime64[us]")
write("types.tdms", numbers + [
    ChannelObject("types", "bool", random.integers(0, 2, 7).astype(bool)),
    ChannelObject("types", "complex64", np.arange(7).astype(np.complex64)),
    ChannelObject("types", "complex128", np.arange(7).astype(np.complex128)),
    ChannelObject("types", "times", times),
    ChannelObject("types", "empty", np.array([], dtype=np.float64)),
    ChannelObject("types", "only properties", None, {"note": "n"}),
    ChannelObject("types", "it's text", ["a", "", "\u00b5m/s", "four"])],
    [ChannelObject("types", "it's text", ["five"]), ChannelObject("types", "times", times[:2]),
     ChannelObject("types", "float64", random.standard_normal(2))])

# A field, a slow channel, times in a channel.
wave = {"wf_increment": 1e-5, "wf_start_offset": -0.25, "wf_samples": 20,
        "wf_start_time": np.datetime64("2026-03-04T05:06:07.000250")}
def site(k, x):
    return ChannelObject("scan", f"p{k}", random.standard_normal(20),
                         {**wave, "unit_string": "mm/s", "Position (mm)": x, "sensor": f"s{k}", "gain": k,
                          "description": "vibrometer", "scale_factor": 2.0, **({"only": 1} if k == 1 else {})})
write("field.tdms", [
    RootObject({"title": "a test", "run": 3, "big": 2**63, "at": np.datetime64("2026-03-04T05:06:07")}),
    GroupObject("scan", {"operator": "me"}),
    site(0, 0.5), site(1, 1.0), site(2, 1.5),
    ChannelObject("scan", "temperature", random.standard_normal(5), {"unit_string": "K"}),
    ChannelObject("log", "Time", np.datetime64("2026-01-01", "us") + np.arange(6) * np.timedelta64(250, "us")),
    ChannelObject("log", "a", random.standard_normal(6).astype(np.float32)),
    ChannelObject("log", "b", random.standard_normal(6).astype(np.float32)),
    ChannelObject("table", "Time (ms)", np.arange(4.0)),
    ChannelObject("table", "u", random.standard_normal(4), {"x": 3, "x_unit": "cm"}),
    ChannelObject("table", "v", random.standard_normal(4), {"x": 1, "x_unit": "cm"}),
    ChannelObject("sets", "a", i16(3), {"x": 0.5, "x_unit": "cm"}),
    ChannelObject("sets", "b", i16(3), {"x": 1.5, "x_unit": "mm"}),
    ChannelObject("sets", "c", i16(2)), ChannelObject("sets", "d", i16(2))])

# Lists that change, samples "as before", several chunks, samples without a description.
a, b, c = ch("a"), ch("b"), ch("c")
parts = [
    segment(META | LIST | RAW, [obj("/"), obj("/'g'"), obj(a, (2, 4), {"gain": 1}), obj(b, (2, 2)), obj(c, (2, 4))],
            i16(10).tobytes()),
    segment(RAW, [], i16(20).tobytes()),
    segment(META | RAW, [obj(b, (2, 1)), obj(a, "same", {"gain": 2, "late": "yes"})], i16(9).tobytes()),
    segment(META | RAW, [obj(b, None)], i16(24).tobytes()),
    segment(META | LIST | RAW, [obj(c, "same"), obj(a, (2, 3))], i16(7).tobytes()),
    segment(META, [obj("/", None, {"end": "yes"})]),
    segment(META | RAW, [obj(b, "same"), obj(ch("d"), (2, 2))], i16(10).tobytes()),
    segment(META | LIST | RAW, [obj(a, (2, 1))], i16(1).tobytes())]
raw("segments.tdms", *parts)

# Interleaved: in place if there is one segment.
three = [obj(ch(k), (9, 4)) for k in "abc"]
floats = lambda n: random.standard_normal(n).astype(np.float32).tobytes()
raw("interleaved.tdms", segment(META | LIST | RAW | INTERLEAVED, three, floats(3 * 12)))
raw("interleaved_segments.tdms", segment(META | LIST | RAW | INTERLEAVED, three, floats(12)),
    segment(RAW | INTERLEAVED, [], floats(24)))
raw("mixed.tdms", segment(META | LIST | RAW | INTERLEAVED,
                          [obj(a, (2, 3)), obj(b, (10, 3)), obj(c, (2, 3))], random.bytes(36)),
    segment(META | LIST | RAW, [obj(a, "same"), obj(c, "same")], i16(6).tobytes()))

# One sample of each channel a segment.
one = [obj(a, (10, 1), {"wf_increment": 0.5, "wf_start_offset": 0.0}), obj(b, (10, 1), {"wf_increment": 0.5, "wf_start_offset": 0.0})]
double = lambda n: random.standard_normal(n).tobytes()
raw("ticks.tdms", segment(META | LIST | RAW, one, double(2)), *[segment(RAW, [], double(2)) for _ in range(9)])
raw("ticks_even.tdms", segment(META | LIST | RAW, one), *[segment(RAW, [], double(2)) for _ in range(9)])

# The high byte first.
be = lambda k, n: of(k, n).astype(np.dtype(k).newbyteorder(">")).tobytes()
stamp = struct.pack(">qQqQ", 3_900_000_000, 1 << 63, -5, 18446744073709)
o = lambda *args: obj(*args, order=">")
raw("big.tdms", segment(META | LIST | RAW | BIG, [
        o(a, (2, 3), {"gain": 7, "t": (3_900_000_000, 1 << 62)}), o(b, (2, 3)), o(ch("time"), (0x44, 2))],
        be("int16", 6) + stamp),
    segment(META | LIST | RAW | BIG | INTERLEAVED, [o(a, (2, 2)), o(b, (2, 2))], be("int16", 8)),
    segment(META | LIST | RAW, [obj(a, (2, 2)), obj(b, (2, 2))], i16(4).tobytes()),
    segment(META | LIST | RAW | BIG, [o(ch("s"), (0x20, 2, 12))], struct.pack(">II", 1, 4) + b"high"))

# A writer that was stopped: the length is open, or longer than the file.
whole = segment(META | LIST | RAW, [obj(a, (3, 4)), obj(b, (3, 4))], of("int32", 8).tobytes())
raw("cut.tdms", whole, segment(RAW, [], of("int32", 8 + 6).tobytes() + b"\1\2", 2**64 - 1))
raw("cut_long.tdms", whole, segment(RAW, [], of("int32", 3).tobytes(), 32))
raw("cut_interleaved.tdms", segment(META | LIST | RAW | INTERLEAVED, [obj(a, (3, 4)), obj(b, (3, 4))],
                                    of("int32", 11).tobytes(), 2**64 - 1))
raw("cut_lead.tdms", whole, segment(META | LIST | RAW, [obj(a, (3, 4))], b"")[:50], )
raw("cut_short.tdms", whole, b"TDSm\0\0")
# A writer that shortened the last chunk.
raw("short_chunk.tdms", segment(META | LIST | RAW, [obj(a, (3, 4)), obj(b, (3, 8))], of("int32", 12 + 6).tobytes()), whole[:0])

# Scalings.
def linear(slope, intercept, n=0, source=None):
    p = {f"NI_Scale[{n}]_Scale_Type": "Linear", f"NI_Scale[{n}]_Linear_Slope": slope,
         f"NI_Scale[{n}]_Linear_Y_Intercept": intercept}
    if source is not None:
        p[f"NI_Scale[{n}]_Linear_Input_Source"] = source
    return p
def polynomial(*values, n=0, source=0xFFFFFFFF):
    k = f"NI_Scale[{n}]_"
    return {k + "Scale_Type": "Polynomial", k + "Polynomial_Coefficients_Size": len(values),
            k + "Polynomial_Input_Source": np.uint32(source),
            **{f"{k}Polynomial_Coefficients[{i}]": v for i, v in enumerate(values)}}
count = lambda n, **more: {"NI_Number_Of_Scales": n, "NI_Scaling_Status": "unscaled", **more}
S = lambda group, name, values, data=None: ChannelObject(group, name, i16(9) if data is None else data, values)
write("scaled.tdms", [
    GroupObject("of group", linear(0.1, 3.0)),
    S("alike", "a", {**count(1), **linear(3e-3, 0.7)}), S("alike", "b", {**count(1), **linear(3e-3, 0.7)}),
    S("each", "a", {**count(1), **linear(3e-3, 0.7)}), S("each", "b", {**count(1), **linear(7e-3, -0.1)}),
    S("curved", "a", {**count(1), **polynomial(0.1, 0.3, 1e-6, -1e-9)}),
    S("flat", "a", {**count(1), **polynomial(0.1, 0.3, 0.0, 0.0)}),
    S("chain", "a", {**count(2), **linear(0.3, 0.1), **polynomial(1.0, 2.0, 0.1, n=1, source=0)}),
    S("of group", "a", {}), S("done", "a", {**linear(3e-3, 0.7), "NI_Scaling_Status": "scaled"}),
    S("uncounted", "a", {**linear(3e-3, 0.7)}),
    S("double", "a", {**count(1), **linear(0.1, 0.2)}, random.standard_normal(9)),
    S("table", "a", {**count(1), "NI_Scale[0]_Scale_Type": "Table", "NI_Scale[0]_Table_Pre_Scaled_Values_Size": 2,
                     "NI_Scale[0]_Table_Scaled_Values_Size": 2, "NI_Scale[0]_Table_Pre_Scaled_Values[0]": 0.0,
                     "NI_Scale[0]_Table_Pre_Scaled_Values[1]": 1.0, "NI_Scale[0]_Table_Scaled_Values[0]": 0.0,
                     "NI_Scale[0]_Table_Scaled_Values[1]": 2.0})])

# A DAQmx device: rows of all channels of a card, two cards.
def device(kind, n, widths, *scalers, header=0x1269):
    out = struct.pack("<IIIQI", header, 0xFFFFFFFF, 1, n, len(scalers))
    for buffer, offset, scale in scalers:
        out += struct.pack("<IIIII", kind, buffer, offset, 0, scale)
    return out + struct.pack("<I", len(widths)) + struct.pack(f"<{len(widths)}I", *widths)
raw("device.tdms", segment(META | LIST | RAW | DAQMX, [
        obj(ch(f"a{k}"), device(3, 5, [6, 4], (0, 2 * k, 0)), {"NI_Number_Of_Scales": 2, **linear(0.5 + k, 0.25, 1, 0)})
        for k in range(3)] + [
        obj(ch("b"), device(5, 5, [6, 4], (1, 0, 0)), {"NI_Number_Of_Scales": 2, **linear(1e-6, 0.25, 1, 0)}),
        obj(ch("unscaled"), device(5, 5, [6, 4], (1, 0, 0)))],
    random.bytes(50 * 3)),
    segment(RAW | DAQMX, [], random.bytes(50 + 18), 2**64 - 1))
raw("device_alike.tdms", segment(META | LIST | RAW | DAQMX, [
    obj(ch(f"a{k}"), device(3, 4, [8], (0, 2 * k, 0)), {"NI_Number_Of_Scales": 2, **linear(0.5, 0.25, 1, 0)})
    for k in range(3)], random.bytes(32 * 3)))

# Channels of several types, units and lengths.
way = lambda unit: {"unit_string": unit, "wf_xunit_string": "s", "wf_increment": 1e-3, "wf_start_offset": 0.0}
doubles = np.array([0.5, -1.25, 3.0])
write("channels.tdms", [
    ChannelObject("g", name, np.asarray(values), way(unit)) for name, values, unit in [
        ("a", doubles, "m/s"), ("b", np.array([0.25, -2.5, 4.0], "f4"), "m/s"), ("c", np.array([7, -8, 9], "i4"), "m/s"),
        ("d", doubles, "mm/s"), ("e", doubles[:2], "m/s"), ("f", doubles, "m/s")]])

with open(os.path.join(here, "expected.json"), "w") as f:
    json.dump(expected, f, indent=0)
