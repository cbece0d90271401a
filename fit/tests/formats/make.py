"""Writes one recording as each format's own tools write it: the files beside this script, which tests/formats.rs reads.

python3 -m venv v && v/bin/pip install numpy pandas pyarrow h5py rosbags && v/bin/python make.py

Versions that wrote the files in the tree: numpy 2.4.6, pandas 3.1.1, pyarrow 26.0.1, h5py 3.16.0, rosbags 0.11.9.
The recording is one joint of two: 12 s at 50 Hz, a spring of 3 N m/rad, Coulomb friction of 1 N m.
"""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
i = np.arange(600)
t = i * 0.02
q = 0.5 * np.sin(1.3 * t) * (1 + 0.2 * np.sin(0.17 * t))
torque = 3.0 * q + np.sign(np.gradient(q))


def table():
    np.savez_compressed(HERE / "columns.npz", t_s=t, q_rad=q, torque_Nm=torque.astype(np.float32), name=np.array("joint"))
    np.savez(HERE / "table.npz", data=np.column_stack([t, q, torque]), rate=np.array(50.0))
    frame = pd.DataFrame({"stamp": pd.to_datetime((i * 20_000_000) + 1_700_000_000_000_000_000), "q_rad": q, "torque_Nm": torque,
                          "counts": (q * 1e4).astype(np.int32), "state": "run"})
    for compression in ["snappy", "zstd", "gzip"]:
        frame.to_parquet(HERE / f"{compression}.parquet", compression=compression, index=False)
    with h5py.File(HERE / "groups.h5", "w") as file:
        axis = file.create_group("axis1")
        axis.create_dataset("t_s", data=t)
        axis.create_dataset("q_rad", data=q, compression="gzip", shuffle=True, chunks=(256,))
        axis.create_dataset("torque_Nm", data=torque.astype(">f4"))
        file.attrs["rig"] = "made"


def types():
    """Every type of real numbers in both byte orders, both orders of a table, and what is no real number."""
    signed, unsigned = np.arange(-3, 4), np.arange(7)
    arrays = {}
    for order, mark in [("little", "<"), ("big", ">")]:
        for kind in ["f4", "f8", "i1", "i2", "i4", "i8"]:
            arrays[f"{order}_{kind}"] = signed.astype(mark + kind)
        for kind in ["u1", "u2", "u4", "u8"]:
            arrays[f"{order}_{kind}"] = unsigned.astype(mark + kind)
        arrays[f"{order}_m8"] = signed.astype(f"{mark}m8[ns]")
    pair = np.column_stack([signed, unsigned])
    record = np.zeros(2, [("a, 'b'", "<f8"), ("c", "<i2", (2,))])
    np.savez_compressed(HERE / "types.npz", **arrays, bool=unsigned.astype(bool), rows=pair, columns=np.asfortranarray(pair),
                        text=np.array(["a", "b"]), complex=1j * signed, record=record, half=signed.astype("f2"), scalar=np.array(50.0),
                        empty=np.array([]))


def matlab73():
    """The layout of `save -v7.3`: a user block of 512 bytes, columns as 1 x N, a class on each variable."""
    path = HERE / "v73.mat"
    with h5py.File(path, "w", userblock_size=512, libver=("earliest", "v108")) as file:
        for name, values in {"t_s": t, "q_rad": q, "torque_Nm": torque}.items():
            one = file.create_dataset(name, data=values.reshape(1, -1), compression="gzip", chunks=(1, 300))
            one.attrs["MATLAB_class"] = np.bytes_("double")
        text = file.create_dataset("note", data=np.frombuffer("made".encode("utf-16-le"), "<u2").reshape(-1, 1))
        text.attrs["MATLAB_class"] = np.bytes_("char")
    with open(path, "r+b") as raw:
        head = b"MATLAB 7.3 MAT-file, Platform: made, Created on: - HDF5 schema 1.00 ."
        raw.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


def bags():
    store = get_typestore(Stores.ROS2_HUMBLE)
    state, header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    stamp, text = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/String"]
    for name, plugin in [("joints.db3", StoragePlugin.SQLITE3), ("joints.mcap", StoragePlugin.MCAP)]:
        folder = HERE / "bag"
        shutil.rmtree(folder, ignore_errors=True)
        with Writer(folder, version=9, storage_plugin=plugin) as bag:
            joints = bag.add_connection("/joint_states", state.__msgtype__, typestore=store)
            other = bag.add_connection("/log", text.__msgtype__, typestore=store)
            for k in range(len(t)):
                ns = 1_700_000_000_000_000_000 + k * 20_000_000
                # The order of the joints changes half way, as it may.
                order = [0, 1] if k < 300 else [1, 0]
                pick = lambda values: np.array([values[j] for j in order])
                message = state(
                    header=header(stamp=stamp(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""),
                    name=[["elbow", "wrist"][j] for j in order],
                    position=pick([q[k], 0.1 * q[k]]),
                    velocity=np.array([]),
                    effort=pick([torque[k], 0.5]),
                )
                bag.write(joints, ns + 3_000_000, store.serialize_cdr(message, state.__msgtype__))
                if k % 200 == 0:
                    bag.write(other, ns, store.serialize_cdr(text(data="made"), text.__msgtype__))
        written = next(p for p in folder.iterdir() if p.suffix in (".db3", ".mcap"))
        shutil.move(written, HERE / name)
        shutil.rmtree(folder)


table()
types()
matlab73()
bags()
