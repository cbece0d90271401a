"""One figure for each command that has one."""

from ._result import Error


def plot(command, result, ax):
    draw = {"identify": _identify, "compare": _compare, "diagnose": _diagnose, "simulate": _simulate}.get(command)
    if draw is None:
        raise Error(f"`{command}` has nothing to draw; print it, or ask for report=\"page.html\"")
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise Error("plots need matplotlib: pip install 'preslide[plot]'") from None
    ax = ax or plt.subplots(layout="constrained")[1]
    draw(result.to_dict(), result, ax)
    return ax


def _identify(found, _, ax):
    sizes = [size for size in found["friction"] if size["blocks"] > 0]
    # Blocks chosen as the paper does, and by search: each a curve of its own.
    for color, method in zip(("tab:orange", "tab:blue"), dict.fromkeys(size["method"] for size in sizes)):
        own = [size for size in sizes if size["method"] == method]
        blocks = [size["blocks"] for size in own]
        ax.semilogy(blocks, [size["nmse_test"] for size in own], "o-", color=color, label=f"{method}, held out")
        ax.semilogy(blocks, [size["nmse_train"] for size in own], "o--", color=color, mfc="none", label=f"{method}, fitted")
    ax.set(xlabel="Maxwell-slip blocks", ylabel="NMSE (%)", title=found["recording"])
    ax.legend()


def _compare(found, _, ax):
    models = found["models"]
    names = [m["kind"] if not m["blocks"] else f"{m['kind']}, N = {m['blocks']}" for m in models]
    ax.barh(names, [m["nmse_test"] for m in models])
    ax.invert_yaxis()
    ax.set(xlabel="NMSE held out (%)", title=found["recording"])


def _diagnose(found, _, ax):
    items = found["budget"]["items"]
    [rms] = [key for key in items[0] if key.startswith("rms_")]
    ax.barh([i["what"].replace("_", " ") for i in items], [i[rms] for i in items])
    ax.invert_yaxis()
    ax.set(xlabel=f"RMS that it takes off ({rms.removeprefix('rms_')})", title=f"{found['recording']}: {found['verdict']}")


def _simulate(found, result, ax):
    time, position, *others = result.data
    # Of a motion the force, which comes last; of a force or a reference the motion.
    name = others[-1] if found["input"] == "motion" else position
    quantity, unit = name.rsplit("_", 1)
    ax.plot(result.data[time], result.data[name])
    ax.set(xlabel="time (s)", ylabel=f"{quantity} ({unit})", title="simulated")
