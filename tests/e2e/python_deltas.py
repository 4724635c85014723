"""A client in a few lines of Python: 1,000 frames, deltas added up as integers, equal to the server's control vertices to the
bit. Usage: python_deltas.py STUBS CAGEFIT CAGEFITD"""
import pathlib
import struct
import subprocess
import sys
import tempfile

FRAMES, CAPTURE = 1000, 40
stubs, cagefit, cagefitd = sys.argv[1:4]
sys.path.insert(0, stubs)
import grpc  # noqa: E402
from cagefit.v1 import fitting_pb2 as pb, fitting_pb2_grpc  # noqa: E402

CRC_TABLE = []
for byte in range(256):
    for _ in range(8):
        byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
    CRC_TABLE.append(byte)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def wrap(value):
    return (value + 2**31) % 2**32 - 2**31


def apply(q, delta):
    """The whole of a decoder: q after this frame."""
    q = list(delta.packed) if delta.key else [wrap(a + b) for a, b in zip(q, delta.packed)]
    assert crc32c(struct.pack(f"<{len(q)}i", *q)) == delta.crc32c, "checksum"
    return q


def positions(q, delta):
    origin = (delta.origin_x, delta.origin_y, delta.origin_z)
    return [origin[k % 3] + delta.quantum * value for k, value in enumerate(q)]


def read_cage(path):
    mesh = pb.ControlMesh()
    for line in path.read_text().splitlines():
        kind, *values = line.split()
        if kind == "v":
            mesh.vertices.extend(map(float, values))
        elif kind == "f":
            mesh.triangles.extend(int(v) - 1 for v in values)
    return mesh


def requests(session_id, frames):
    yield pb.FitFramesRequest(open=pb.OpenStream(session_id=session_id))
    for number in range(FRAMES):
        k = number % (2 * CAPTURE)  # to and fro
        data = frames[k if k < CAPTURE else 2 * CAPTURE - 1 - k]
        yield pb.FitFramesRequest(header=pb.FrameHeader(sequence_number=number, total_bytes=len(data)))
        yield pb.FitFramesRequest(chunk=pb.FrameChunk(data=data))


def main(folder):
    subprocess.run([cagefit, "synth", "blob", "--out", folder, "--frames", str(CAPTURE), "--points", "1500"], check=True)
    frames = [path.read_bytes() for path in sorted(pathlib.Path(folder).glob("frame_*.drc"))]
    cage_path = pathlib.Path(folder) / "cage.obj"
    subprocess.run([cagefit, "template", f"{folder}/truth/frame_0000.ply", "--vertices", "60", "--out", str(cage_path)], check=True)
    with subprocess.Popen([cagefitd, "--listen", "127.0.0.1:0", "--log-level", "off", "--store", "memory"], stdout=subprocess.PIPE, text=True) as server:
        try:
            check(server.stdout.readline().split()[-1], frames, read_cage(cage_path))
        finally:
            server.terminate()


def check(address, frames, cage):
    stub = fitting_pb2_grpc.FittingStub(grpc.insecure_channel(address))
    session_id = stub.CreateSession(pb.CreateSessionRequest(control_mesh=cage)).session_id
    q, keys, compared = [], 0, 0
    for reply in stub.FitFrames(requests(session_id, frames)):
        if not reply.HasField("frame"):
            continue
        frame = reply.frame
        assert frame.outcome == pb.OUTCOME_FITTED, frame.error.message
        q = apply(q, frame.delta)
        keys += frame.delta.key
        if frame.sequence_number % 50 == 0 or frame.sequence_number == FRAMES - 1:
            chunks = stub.GetControlMesh(pb.GetControlMeshRequest(session_id=session_id, sequence_number=frame.sequence_number))
            mesh = pb.ControlMesh.FromString(b"".join(chunk.data for chunk in chunks))
            assert list(mesh.vertices) == positions(q, frame.delta), f"frame {frame.sequence_number} differs"
            compared += 1
    assert frame.sequence_number == FRAMES - 1
    print(f"{FRAMES} frames, {keys} of them key frames; {compared} compared with the server's control vertices, all equal")


with tempfile.TemporaryDirectory() as temporary:
    main(temporary)
