#!/usr/bin/env python3
"""Lowers Cagefit's loss with torch's Adam: a fit whose loop is yours.

    PYTHONPATH=build/release/python client/python/lower_loss.py 127.0.0.1:50051 cage.obj frame.drc --out fitted.obj
"""
import argparse
import pathlib

import grpc
import torch

import cagefit_torch


def main():
    arguments = argparse.ArgumentParser(description="Lower Cagefit's loss with torch's Adam.")
    arguments.add_argument("address", help="HOST:PORT or unix:PATH of cagefitd")
    arguments.add_argument("cage", help="control mesh, .obj")
    arguments.add_argument("frame", help="point cloud or mesh, Draco bytes")
    arguments.add_argument("--steps", type=int, default=200)
    arguments.add_argument("--learning-rate", type=float, default=0.002, help="share of the cage's size")
    arguments.add_argument("--out", help="write the control mesh there, .obj")
    a = arguments.parse_args()

    session = cagefit_torch.Session.create(grpc.insecure_channel(a.address), cagefit_torch.read_obj(a.cage))
    frame = pathlib.Path(a.frame).read_bytes()
    vertices = session.template().requires_grad_()
    size = float((vertices.max(0).values - vertices.min(0).values).max())
    adam = torch.optim.Adam([vertices], lr=a.learning_rate * size)
    for step in range(a.steps + 1):
        adam.zero_grad()
        loss = cagefit_torch.cagefit_loss(vertices, session, frame)
        if step % 20 == 0 or step == a.steps:
            print(f"step {step:4d}  loss {loss.item():.3e}", flush=True)
        loss.backward()
        if step < a.steps:
            adam.step()
    if a.out:
        lines = ["v %.17g %.17g %.17g" % tuple(v) for v in vertices.tolist()]
        faces = [line.strip() for line in open(a.cage) if line.startswith("f ")]
        pathlib.Path(a.out).write_text("\n".join(lines + faces) + "\n")


if __name__ == "__main__":
    main()
