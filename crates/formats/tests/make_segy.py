"""Writes the SEG-Y and Seismic Unix fixtures, and what segyio reads from them.

segyio 1.9.14, numpy 2.4.6: `python make_segy.py` in this folder.
"""
import json, os
import numpy as np, segyio
from segyio import TraceField as T, BinField as B

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "segy")
os.makedirs(here, exist_ok=True)
expected = {}
random = np.random.default_rng(7)

def make(name, code, dtype, endian="big", ext=0, place=lambda i: {}, traces=5, samples=12, binary={}):
    path = os.path.join(here, name)
    spec = segyio.spec()
    spec.format, spec.samples, spec.tracecount = code, range(samples), traces
    spec.endian, spec.ext_headers = endian, ext
    if np.issubdtype(dtype, np.floating):
        data = random.standard_normal((traces, samples)).astype(dtype)
    else:
        i = np.iinfo(dtype)
        data = random.integers(i.min, i.max, (traces, samples), dtype, endpoint=True)
    with segyio.create(path, spec) as f:
        f.text[0] = segyio.tools.create_text_header({1: "LINE A", 2: "(DEPTH) < 10 & > 3"})
        f.bin.update({B.Interval: 2001, B.Samples: samples, **binary})
        for i in range(traces):
            f.header[i] = {T.TRACE_SAMPLE_COUNT: samples, T.TRACE_SAMPLE_INTERVAL: 2001, **place(i)}
            f.trace[i] = data[i]
    record(name, path, endian)

def record(name, path, endian, opener=segyio.open, **more):
    with opener(path, ignore_geometry=True, endian=endian, **more) as f:
        head = lambda field: np.array([int(h[field]) for h in f.header], "f8")
        array = lambda data: {"type": data.dtype.kind + str(data.dtype.itemsize), "shape": list(data.shape),
                              "hex": data.astype(data.dtype.newbyteorder("<")).tobytes().hex()}
        scalar = head(T.SourceGroupScalar)[0]
        scale = -scalar if scalar < 0 else 1.0
        found = expected[name] = {"/traces": array(np.array([np.array(t) for t in f.trace]))}
        for field, values in [("group_x", head(T.GroupX) / scale), ("group_y", head(T.GroupY) / scale),
                              ("offset", head(T.offset)), ("delay", head(T.DelayRecordingTime))]:
            if values.any():
                found[field] = array(values)
        if opener is segyio.open:
            text = bytes(f.text[0]).decode("ascii")
            lines = [text[i:i + 80].rstrip() for i in range(0, len(text), 80)]
            found["."] = {"attributes": {"text": "\n".join(lines).strip()}}

line = lambda i: {T.GroupX: 1000 + 125 * i, T.GroupY: 77, T.SourceGroupScalar: -10, T.DelayRecordingTime: 40}
slant = lambda i: {T.GroupX: 300 * i, T.GroupY: 400 * i + 5, T.offset: -i}
offset = lambda i: {T.offset: 10 * i, T.GroupX: 5, T.CoordinateUnits: 2, T.SourceX: 3 * i}
make("ibm.sgy", 1, np.float32, place=line)
make("i32.sgy", 2, np.int32, place=slant)
make("i16.sgy", 3, np.int16, place=offset, binary={B.MeasurementSystem: 2})
make("f32.sgy", 5, np.float32, ext=2, binary={B.SEGYRevision: 1}, place=lambda i: {T.DelayRecordingTime: i})
make("f64.sgy", 6, np.float64)
make("i8.sgy", 8, np.int8)
make("u32.sgy", 10, np.uint32)
make("u16.sgy", 11, np.uint16)
make("u8.sgy", 16, np.uint8)
make("little.sgy", 5, np.float32, endian="little", place=line)
for endian in ("big", "little"):
    source = os.path.join(here, "tmp.sgy")
    make("tmp.sgy", 5, np.float32, endian=endian, place=line)
    name = f"{endian}.su"
    path = os.path.join(here, name)
    open(path, "wb").write(open(source, "rb").read()[3600:])
    os.remove(source); del expected["tmp.sgy"]
    record(name, path, endian, opener=segyio.su.open)
with open(os.path.join(here, "expected.json"), "w") as f:
    json.dump(expected, f)
