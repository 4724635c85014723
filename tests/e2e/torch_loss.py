"""The loss inside PyTorch: gradcheck, and the example that lowers it. Usage: torch_loss.py PACKAGE EXAMPLE CAGEFIT CAGEFITD.
Ends with 77, skipped, where torch is missing."""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

package, example, cagefit, cagefitd = sys.argv[1:5]
sys.path.insert(0, package)
try:
    import torch
except ImportError:
    print("skipped: torch is missing; install python3-torch")
    sys.exit(77)
import grpc  # noqa: E402
import cagefit_torch  # noqa: E402
from cagefit.v1 import fitting_pb2 as pb  # noqa: E402


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True,
                          env=dict(os.environ, PYTHONPATH=package)).stdout


def fit(session, data):
    """Makes `data` the session's last frame."""
    requests = [pb.FitFramesRequest(open=pb.OpenStream(session_id=session.session_id)),
                pb.FitFramesRequest(header=pb.FrameHeader(sequence_number=0, total_bytes=len(data))),
                pb.FitFramesRequest(chunk=pb.FrameChunk(data=data))]
    for reply in session.stub.FitFrames(iter(requests)):
        assert not reply.HasField("frame") or reply.frame.outcome == pb.OUTCOME_FITTED, reply.frame.error.message


def check_gradient(session, vertices, frame):
    """Every component, against central differences that choose radii and feet anew on both sides."""
    gradient = torch.autograd.grad(cagefit_torch.cagefit_loss(vertices, session, frame), vertices)[0]
    largest = float(gradient.abs().max())
    assert largest > 1e-3, "a gradient of 0 would prove nothing"
    torch.autograd.gradcheck(lambda v: cagefit_torch.cagefit_loss(v, session, frame), (vertices,), eps=1e-6,
                             atol=1e-5 * largest, rtol=1e-4)
    print(f"gradcheck of {vertices.numel()} components, the largest {largest:.3g}, within 1e-4 of each and 1e-5 of that")
    return gradient


def check(channel, cage, frame):
    session = cagefit_torch.Session.create(channel, cage)
    torch.manual_seed(3)
    template = session.template()
    spoiled = template + 0.02 * torch.randn_like(template)
    vertices = spoiled.clone().requires_grad_()
    check_gradient(session, vertices, frame)
    fit(session, frame)
    gradient = check_gradient(session, vertices, None)

    # Through the graph: a factor above, a leaf below, and single precision.
    leaf = spoiled.float().requires_grad_()
    (3 * cagefit_torch.cagefit_loss(leaf.double(), session)).backward()
    assert leaf.grad.dtype == torch.float32
    assert torch.allclose(leaf.grad.double(), 3 * gradient, rtol=1e-3, atol=1e-3 * float(gradient.abs().max()))

    S, triangles = session.stencils(levels=1)
    assert S.shape == (int(triangles.max()) + 1, len(template))
    assert torch.allclose(torch.sparse.sum(S, 1).to_dense(), torch.ones(len(S), dtype=torch.float64))
    assert session.stencils()[0].shape == S.shape  # the fit samples these vertices, too
    try:
        cagefit_torch.cagefit_loss(vertices[:-1], session)
        raise AssertionError("a vertex is missing and nobody minds")
    except grpc.RpcError as error:
        assert error.code() == grpc.StatusCode.INVALID_ARGUMENT and "vertices" in error.details(), error


def main(folder):
    run(cagefit, "synth", "blob", "--out", folder, "--frames", 2, "--points", 3000)
    run(cagefit, "template", folder / "truth/frame_0000.ply", "--vertices", 40, "--out", folder / "cage.obj")
    frame = folder / "frame_0001.drc"
    with subprocess.Popen([cagefitd, "--listen", "127.0.0.1:0", "--log-level", "off", "--store", "memory"], stdout=subprocess.PIPE, text=True) as server:
        try:
            address = server.stdout.readline().split()[-1]
            check(grpc.insecure_channel(address), cagefit_torch.read_obj(folder / "cage.obj"), frame.read_bytes())
            output = run(sys.executable, example, address, folder / "cage.obj", frame, "--steps", 60, "--out", folder / "fitted.obj")
        finally:
            server.terminate()
    print(output, end="")
    losses = [float(loss) for loss in re.findall(r"loss (\S+)", output)]
    assert losses[-1] < 0.2 * losses[0], "Adam does not lower the loss"
    assert len((folder / "fitted.obj").read_text().splitlines()) == len((folder / "cage.obj").read_text().splitlines())


with tempfile.TemporaryDirectory() as temporary:
    main(pathlib.Path(temporary))
