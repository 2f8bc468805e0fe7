"""Writes the fixtures of miniSEED files, and what ObsPy (version 2) and pymseed (version 3) read from them.

ObsPy 1.5.1, pymseed 1.0.1, numpy 2.4.6: `python make_miniseed.py` in this folder.
"""
import json, os, struct
from datetime import datetime, timedelta
import numpy as np
from obspy import Stream, Trace, UTCDateTime, read
from pymseed import DataEncoding, MS3Record

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "miniseed")
os.makedirs(here, exist_ok=True)
random = np.random.default_rng(3)
expected = {}
START = UTCDateTime("2024-02-29T23:59:59.123400")

def hexed(array):
    return np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes().hex()

def trace(data, channel="HHZ", start=START, rate=100.0, station="STA", location="00"):
    return Trace(data, dict(network="XX", station=station, location=location, channel=channel,
                            sampling_rate=rate, starttime=start))

def found(kind, digits, rate, delta, start):
    """A trace; its start in nanoseconds."""
    seconds = datetime(1970, 1, 1) + timedelta(seconds=start // 10**9)
    text = (seconds.isoformat() + f".{start % 10**9:09}").rstrip("0").rstrip(".")
    return {"type": kind, "shape": [len(digits) // 2 // int(kind[1:])], "hex": digits, "even": [0.0, delta],
            "attributes": {"sampling_rate": rate, "start_time": text}}

def check(name):
    """What ObsPy reads; traces with gaps and overlaps are several, and refused."""
    if name not in ("gap.mseed", "overlap.mseed"):
        expected[name] = {
            t.id: found(t.data.dtype.kind + str(t.data.dtype.itemsize), hexed(t.data), float(t.stats.sampling_rate),
                        float(t.stats.delta), t.stats.starttime._ns)
            for t in read(os.path.join(here, name), format="MSEED")}

def write(name, traces, patch=None, **more):
    path = os.path.join(here, name)
    Stream(traces).write(path, format="MSEED", **more)
    if patch:
        data = bytearray(open(path, "rb").read())
        patch(data)
        open(path, "wb").write(data)
    check(name)

def walk(n, most):
    return np.cumsum(random.integers(-most, most + 1, n)).astype(np.int32)

# Differences of all widths.
widths = [3, 7, 15, 31, 127, 511, 2**14 - 1, 2**29 - 1]
def wide(n=60):
    steps = np.concatenate([random.integers(-w // 2, w // 2 + 1, n) for w in widths] + [random.integers(-3, 4, n)])
    return np.cumsum(steps).astype(np.int64).astype(np.int32)

channels = ("HHE", "HHN", "HHZ")
for encoding in ("STEIM1", "STEIM2"):
    for order in "<>":
        name = f"{encoding.lower()}_{'little' if order == '<' else 'big'}.mseed"
        write(name, [trace(wide(), c) for c in channels[:2]], encoding=encoding, reclen=256, byteorder=order)
for order in "<>":
    more = dict(reclen=256, byteorder=order)
    end = "little" if order == "<" else "big"
    write(f"int16_{end}.mseed", [trace(walk(200, 9).astype(np.int16))], encoding="INT16", **more)
    write(f"int32_{end}.mseed", [trace(walk(200, 9))], encoding="INT32", **more)
    write(f"float32_{end}.mseed", [trace(random.standard_normal(200).astype(np.float32))], encoding="FLOAT32", **more)
    write(f"float64_{end}.mseed", [trace(random.standard_normal(200))], encoding="FLOAT64", **more)
# A set of three, a trace of its own, one of another type. ObsPy reads them before their records are shuffled.
several = [trace(walk(300, 50), c) for c in channels] + [
    trace(walk(100, 5), "LOG", rate=0.1, start=START + 5.25), trace(random.standard_normal(40), "HHZ", station="B")]
write("several.mseed", several, reclen=256)
path = os.path.join(here, "several.mseed")
data = open(path, "rb").read()
records = [data[i:i + 256] for i in range(0, len(data), 256)]
random.shuffle(records)
open(path, "wb").write(b"".join(records))
# A start with microseconds (blockette 1001), a rate that only blockette 100 holds.
write("exact.mseed", [trace(walk(300, 50), start=UTCDateTime("1969-12-31T23:59:58.000037"), rate=123.4567)], reclen=256)
# A correction of the time that is not yet applied: -1.5 s, and one that is.
def correct(flag):
    def patch(data):
        for at in range(0, len(data), 256):
            data[at + 36] |= flag
            data[at + 40:at + 44] = struct.pack(">i", -15000)
    return patch
write("corrected.mseed", [trace(walk(200, 5))], correct(0), reclen=256, encoding="INT32")
write("corrected_before.mseed", [trace(walk(200, 5))], correct(2), reclen=256, encoding="INT32")
# Records whose starts drift by 0.2 samples each.
def drift(data):
    for i, at in enumerate(range(0, len(data), 256)):
        fraction, = struct.unpack(">H", data[at + 28:at + 30])
        data[at + 28:at + 30] = struct.pack(">H", fraction + 20 * i)
write("drift.mseed", [trace(walk(400, 5), start=UTCDateTime("2024-01-01"))], drift, reclen=256, encoding="INT32")
# What is refused.
a, b = walk(100, 9), walk(100, 9)
write("gap.mseed", [trace(a), trace(b, start=START + 1.5)], reclen=256)
write("overlap.mseed", [trace(a), trace(b, start=START + 0.9)], reclen=256)

def version_3(name, *traces):
    path = os.path.join(here, name)
    with open(path, "wb") as f:
        for source, start, rate, encoding, data, kind, length in traces:
            msr = MS3Record(reclen=length, encoding=encoding)
            msr.formatversion = 3
            msr.sourceid, msr.starttime, msr.samprate = source, start, rate
            msr.extra = '{"FDSN":{"Time":{"Quality":100}}}'
            for record in msr.generate(data_samples=data, sample_type=kind):
                f.write(record)
    traces = {}
    for msr in MS3Record.from_file(path, unpack_data=True):
        one = traces.setdefault(msr.sourceid, {"source": msr.sourceid, "start": msr.starttime,
            "rate": msr.samprate, "delta": 1 / msr.samprate, "hex": "",
            "type": {"i": "i4", "f": "f4", "d": "f8", "t": "text"}[msr.sampletype]})
        if msr.sampletype != "t":
            one["hex"] += hexed(np.array(msr.np_datasamples))
    expected[name] = {}
    for one in traces.values():
        codes = one["source"].removeprefix("FDSN:").split("_")
        expected[name][".".join(codes[:3]) + "." + "".join(codes[3:])] = {"other": "text"} if one["type"] == "text" else \
            found(one["type"], one["hex"], one["rate"], one["delta"], one["start"])

start = 1_709_251_199_123_456_789
version_3("v3.mseed3",
    *[(f"FDSN:XX_STA_00_H_H_{c}", start, 250.0, DataEncoding.STEIM2, wide(), "i", 400) for c in "ENZ"],
    ("FDSN:XX_STA_00_L_H_Z", start + 1, -10.0, DataEncoding.FLOAT64, random.standard_normal(60), "d", 200),
    ("FDSN:XX_STA_00_B_H_Z", start, 20.0, DataEncoding.STEIM1, wide(), "i", 300),
    ("FDSN:XX_STA_00_B_H_N", start, 20.0, DataEncoding.INT32, walk(50, 9), "i", 300),
    ("FDSN:XX_STA_00_B_H_E", start, 20.0, DataEncoding.FLOAT32, random.standard_normal(50).astype(np.float32), "f", 300),
    ("FDSN:XX_STA_00_L_O_G", start, 1.0, DataEncoding.TEXT, "state of health", "t", 300))

with open(os.path.join(here, "expected.json"), "w") as f:
    json.dump(expected, f, indent=0)
