"""Streams a folder of .drc files through a server and writes the fitted control mesh of each as OBJ.

    PYTHONPATH=build/release/python python3 client/python/fit_folder.py CAPTURE OUT --server rig:50051 --vertices 2000
"""
import argparse
import pathlib
import sys

import grpc
from cagefit.v1 import fitting_pb2 as pb, fitting_pb2_grpc

CHUNK = 1 << 20


def wrap(value):
    """As 32-bit integers overflow."""
    return (value + 2**31) % 2**32 - 2**31


def requests(session_id, files):
    yield pb.FitFramesRequest(open=pb.OpenStream(session_id=session_id))
    for number, file in enumerate(files):
        data = file.read_bytes()
        yield pb.FitFramesRequest(header=pb.FrameHeader(sequence_number=number, total_bytes=len(data)))
        for at in range(0, len(data), CHUNK):
            yield pb.FitFramesRequest(chunk=pb.FrameChunk(data=data[at:at + CHUNK]))


def write_obj(path, vertices, triangles):
    with path.open("w") as obj:
        for k in range(0, len(vertices), 3):
            obj.write("v {!r} {!r} {!r}\n".format(*vertices[k:k + 3]))
        for k in range(0, len(triangles), 3):
            obj.write("f {} {} {}\n".format(*(v + 1 for v in triangles[k:k + 3])))


def fit(stub, files, out, vertices):
    session_id = stub.CreateSession(pb.CreateSessionRequest(make_template=pb.MakeTemplate(vertices=vertices))).session_id
    q, triangles, fitted = [], [], 0
    for reply in stub.FitFrames(requests(session_id, files), metadata=[("x-session-id", session_id)]):
        if not reply.HasField("frame"):
            continue  # the stream is open
        frame = reply.frame
        file = files[frame.sequence_number]
        if frame.outcome != pb.OUTCOME_FITTED:
            print(f"{file.name}: {frame.error.message}", file=sys.stderr)
            continue
        delta = frame.delta
        q = list(delta.packed) if delta.key else [wrap(a + b) for a, b in zip(q, delta.packed)]
        if frame.HasField("template"):
            triangles = frame.template.triangles
        origin = (delta.origin_x, delta.origin_y, delta.origin_z)
        write_obj(out / f"{file.stem}.obj", [origin[k % 3] + delta.quantum * value for k, value in enumerate(q)], triangles)
        print(f"{file.name}: RMS {frame.distances.rms_percent:.4f} %")
        fitted += 1
    stub.DeleteSession(pb.DeleteSessionRequest(session_id=session_id))
    return fitted


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--server", default="127.0.0.1:50051")
    parser.add_argument("--vertices", type=int, default=2000)
    arguments = parser.parse_args()
    files = sorted(arguments.capture.glob("*.drc"))
    if not files:
        parser.error(f"{arguments.capture} has no .drc files")
    arguments.out.mkdir(parents=True, exist_ok=True)
    with grpc.insecure_channel(arguments.server) as channel:
        fitted = fit(fitting_pb2_grpc.FittingStub(channel), files, arguments.out, arguments.vertices)
    sys.exit(0 if fitted == len(files) else 4)


if __name__ == "__main__":
    main()
