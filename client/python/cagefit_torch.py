"""Cagefit's loss inside PyTorch: how far a subdivision surface is from a frame, with its gradient to the control vertices.

    channel = grpc.insecure_channel("127.0.0.1:50051")
    session = Session.create(channel, read_obj("cage.obj"))
    vertices = session.template().requires_grad_()
    loss = cagefit_loss(vertices, session, pathlib.Path("frame.drc").read_bytes())
    loss.backward()  # vertices.grad is d loss / d vertices

Needs python3-grpcio, python3-protobuf, python3-torch, and on the path the stubs that the build writes beside this file into
build/release/python.
"""
import torch
from torch.autograd.function import once_differentiable

from cagefit.v1 import fitting_pb2 as pb, fitting_pb2_grpc

CHUNK_BYTES = 1 << 20


class Session:
    """A session on a server. Calls raise grpc.RpcError; they may come from several threads."""

    def __init__(self, channel, session_id):
        self.stub = fitting_pb2_grpc.FittingStub(channel)
        self.session_id = session_id

    @classmethod
    def create(cls, channel, control_mesh, options=None):
        """A new session on a pb.ControlMesh that fits in one message (1 MiB)."""
        request = pb.CreateSessionRequest(control_mesh=control_mesh, options=options)
        return cls(channel, fitting_pb2_grpc.FittingStub(channel).CreateSession(request).session_id)

    def evaluate_loss(self, vertices, frame=None):
        """pb.EvaluateLossReply for a flat list of 3 n numbers. `frame`: Draco bytes, or None: the frame fitted last."""
        request = pb.EvaluateLossRequest(session_id=self.session_id, vertices=vertices)
        if frame is not None:
            request.frame.data = frame
        data = request.SerializeToString()
        chunks = (pb.DataChunk(total_bytes=len(data), data=data[k : k + CHUNK_BYTES]) for k in range(0, len(data), CHUNK_BYTES))
        return pb.EvaluateLossReply.FromString(join(self.stub.EvaluateLoss(chunks)))

    def template(self):
        """Control vertices that the session starts from, n x 3, double."""
        request = pb.GetControlMeshRequest(session_id=self.session_id, template=True)
        mesh = pb.ControlMesh.FromString(join(self.stub.GetControlMesh(request)))
        return torch.tensor(mesh.vertices, dtype=torch.float64).reshape(-1, 3)

    def stencils(self, levels=None):
        """S, a sparse m x n tensor, and triangles (F x 3): S @ vertices are points of the limit surface, those that the fit
        samples or, with `levels`, the vertices of the mesh refined so often, for which there are triangles."""
        request = pb.GetStencilsRequest(session_id=self.session_id, levels=levels)
        s = pb.Stencils.FromString(join(self.stub.GetStencils(request)))
        begin = torch.tensor(s.row_begin, dtype=torch.int64)
        rows = torch.repeat_interleave(torch.arange(s.rows), begin[1:] - begin[:-1])
        indices = torch.stack([rows, torch.tensor(s.column, dtype=torch.int64)])
        values = torch.tensor(s.value, dtype=torch.float64)
        S = torch.sparse_coo_tensor(indices, values, (s.rows, s.columns)).coalesce()
        return S, torch.tensor(s.triangles, dtype=torch.int64).reshape(-1, 3)


def join(chunks):
    return b"".join(chunk.data for chunk in chunks)


class CagefitLoss(torch.autograd.Function):
    """The server gives value and gradient at once: forward keeps the gradient, backward hands it out."""

    @staticmethod
    def forward(ctx, vertices, session, frame):
        reply = session.evaluate_loss(vertices.detach().reshape(-1).tolist(), frame)
        gradient = torch.tensor(reply.gradient, dtype=vertices.dtype, device=vertices.device)
        ctx.save_for_backward(gradient.reshape(vertices.shape))
        return vertices.new_tensor(reply.total)

    @staticmethod
    @once_differentiable
    def backward(ctx, grad_output):
        (gradient,) = ctx.saved_tensors
        return grad_output * gradient, None, None


def cagefit_loss(vertices, session, frame=None):
    """The energy that a fit of `session` to `frame` would minimise, a scalar, at `vertices` (n x 3). It is smooth but where
    a sample changes its radius or a point its foot; its gradient takes these choices as they are at `vertices`."""
    return CagefitLoss.apply(vertices, session, frame)


def read_obj(path):
    """The vertices and triangles of an OBJ file as pb.ControlMesh."""
    mesh = pb.ControlMesh()
    with open(path) as lines:
        for line in lines:
            kind, *values = line.split() or [""]
            if kind == "v":
                mesh.vertices.extend(map(float, values))
            elif kind == "f":
                mesh.triangles.extend(int(value.split("/")[0]) - 1 for value in values)
    return mesh
