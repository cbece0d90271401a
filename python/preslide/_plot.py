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
    ax.semilogy([s["blocks"] for s in sizes], [s["nmse_test"] for s in sizes], "o-", label="held out")
    ax.semilogy([s["blocks"] for s in sizes], [s["nmse_train"] for s in sizes], "o--", label="fitted")
    ax.set(xlabel="Maxwell-slip blocks", ylabel="NMSE (%)", title=found["recording"])
    ax.legend()


def _compare(found, _, ax):
    models = found["models"]
    names = [m["kind"] if not m["blocks"] else f"{m['kind']}, N = {m['blocks']}" for m in models]
    ax.barh(names, [m["nmse_test"] for m in models])
    ax.invert_yaxis()
    ax.set(xscale="log", xlabel="NMSE held out (%)", title=found["recording"])


def _diagnose(found, _, ax):
    items = found["budget"]["items"]
    ax.barh([i["what"].replace("_", " ") for i in items], [i["rms"] for i in items])
    ax.invert_yaxis()
    ax.set(xlabel="RMS that it takes off", title=f"{found['recording']}: {found['verdict']}")


def _simulate(_, result, ax):
    time, *others = result.data
    name = next(key for key in others if not key.startswith(("x_m", "q_rad")) or len(others) == 1)
    ax.plot(result.data[time], result.data[name])
    ax.set(xlabel="time (s)", ylabel=name)
