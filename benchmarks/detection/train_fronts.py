"""Trains the network that tells bodies' fronts from a bed's, from what `benchmarks.detection.fronts_seen` drew.

`python -m benchmarks.detection.train_fronts SEEN.npz ... [--out ods/pipeline/fronts/network.npz]`; for the one that
comes with ODS 700 scenes each of `--seed` 0 to 3, some minutes by one thread. It needs PyTorch, which ODS does not:
`pip install torch`. One scene of five is held out; the share of its bodies' echoes that is found where one echo of the
bed in a thousand, in three hundred, ... is taken for a body's is printed.
"""

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch  # type: ignore[import-not-found,unused-ignore]

from benchmarks.detection.fronts_seen import HARDLY, MOSTLY
from ods.base.arrays import AnyArray, Floats, Floats32, Mask
from ods.pipeline.fronts.judge import BEAMS, CELLS
from ods.pipeline.fronts.network import DB, WEIGHTS, network_of

CHANNELS, KERNELS, STEPS, HIDDEN = (16, 32, 32), ((3, 5), (3, 5), (3, 3)), ((1, 2), (2, 2), (1, 2)), 48
EPOCHS, BATCHES, BATCH, BODIES = 40, 400, 256, 85
RATE, DECAY, DROPPED = 4e-3, 0.02, 0.3
SHIFT = 2
"""Cells that windows are moved by, at most, so that it does not depend on where exactly an echo is said to set in."""
HELD_OUT = 5
FALSE_SHARES = (0.001, 0.003, 0.01, 0.03, 0.1)


class Echoes(NamedTuple):
    """What there is to learn from."""

    windows: AnyArray
    """(echoes, BEAMS, CELLS) dB."""
    body: Floats32
    """(echoes,) 1: a body's, 0: the bed's."""
    held_out: Mask
    """(echoes,)"""


def echoes_of(files: list[Path]) -> Echoes:
    """Return the echoes of files that are clearly one or the other."""
    parts = []
    for file in files:
        with np.load(file) as arrays:
            share = arrays["body"]
            clear = (share > MOSTLY) | (share < HARDLY)
            parts.append([arrays["windows"][clear], share[clear] > MOSTLY, arrays["scene"][clear] % HELD_OUT == 0])
    windows, body, held_out = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Echoes(windows, body.astype(np.float32), held_out)


def new_model() -> Any:
    """Return an untrained network; normalized between layers, which is taken into the weights in the end."""
    layers: list[Any] = []
    before, beams, cells = 1, BEAMS, CELLS
    for channels, kernel, step in zip(CHANNELS, KERNELS, STEPS, strict=True):
        padding = tuple(size // 2 for size in kernel)
        layers += [torch.nn.Conv2d(before, channels, kernel, stride=step, padding=padding)]
        layers += [torch.nn.BatchNorm2d(channels), torch.nn.ReLU()]
        before, beams, cells = channels, -(-beams // step[0]), -(-cells // step[1])
    seen = before * beams * cells
    layers += [torch.nn.Flatten(), torch.nn.Linear(seen, HIDDEN), torch.nn.ReLU()]
    return torch.nn.Sequential(*layers, torch.nn.Dropout(DROPPED), torch.nn.Linear(HIDDEN, 1))


def train(echoes: Echoes, seed: int) -> Any:
    """Return a model trained on what is not held out: the same for the same seed."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    model = new_model()
    optimizer = torch.optim.AdamW(model.parameters(), RATE / 2.0, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, EPOCHS * BATCHES)
    bodies, others = (np.flatnonzero((echoes.body == is_body) & ~echoes.held_out) for is_body in (1.0, 0.0))
    for epoch in range(EPOCHS):
        model.train()
        for _ in range(BATCHES):
            rows = np.concatenate([rng.choice(bodies, BODIES), rng.choice(others, BATCH - BODIES)])
            windows = torch.from_numpy(echoes.windows[rows, None].astype(np.float32) / DB)
            mirrored = torch.from_numpy(rng.random(BATCH) < 0.5)
            windows[mirrored] = windows[mirrored].flip(2)
            windows = torch.roll(windows, int(rng.integers(-SHIFT, SHIFT + 1)), 3)
            wanted = torch.from_numpy(echoes.body[rows])
            loss = torch.nn.functional.binary_cross_entropy_with_logits(model(windows)[:, 0], wanted)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
        print(f"epoch {epoch + 1}: loss {loss.item():.3f}", flush=True)
    return model.eval()


def arrays_of(model: Any) -> dict[str, Floats32]:
    """Return the weights as `network_of` takes them; what normalizes is in them."""
    arrays: dict[str, Floats32] = {}
    layers = list(model)
    found = [k for k, layer in enumerate(layers) if isinstance(layer, torch.nn.Conv2d)]
    for number, k in enumerate(found):
        layer, norm = layers[k], layers[k + 1]
        scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        weights = layer.weight * scale[:, None, None, None]  # (out, in, beams, cells)
        arrays[f"convolution{number}"] = weights.detach().numpy().transpose(2, 3, 1, 0)
        arrays[f"convolution{number}_bias"] = ((layer.bias - norm.running_mean) * scale + norm.bias).detach().numpy()
    hidden, last = (layer for layer in layers if isinstance(layer, torch.nn.Linear))
    places = hidden.weight.detach().numpy().reshape(HIDDEN, CHANNELS[-1], -1)  # which torch has before beams and cells
    arrays["hidden"] = places.transpose(2, 1, 0).reshape(-1, HIDDEN)
    arrays["last"] = last.weight.detach().numpy().T
    arrays["steps"] = np.array(STEPS, np.float32)
    arrays["hidden_bias"], arrays["last_bias"] = hidden.bias.detach().numpy(), last.bias.detach().numpy()
    return {name: np.ascontiguousarray(array, np.float32) for name, array in arrays.items()}


def found_shares(scores: Floats | Floats32, echoes: Echoes) -> dict[float, float]:
    """Return the share of bodies' echoes held out over the score that such a share of the bed's is over."""
    body = echoes.body[echoes.held_out] > 0.0
    others = np.sort(scores[~body])[::-1]
    return {share: float((scores[body] > others[int(share * len(others))]).mean()) for share in FALSE_SHARES}


def main() -> None:
    """Train, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seen", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, default=WEIGHTS)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    echoes = echoes_of(args.seen)
    arrays = arrays_of(train(echoes, args.seed))
    held_out = echoes.windows[echoes.held_out].astype(np.float32)
    network = network_of(arrays)
    scores = np.concatenate([network.scores(part) for part in np.array_split(held_out, len(held_out) // 500)])
    print(f"{len(echoes.body)} echoes, {echoes.held_out.sum()} held out")
    for share, found in found_shares(scores, echoes).items():
        print(f"{100 * share:.1f} % of the bed's taken for bodies': {100 * found:.1f} % of the bodies' found")
    np.savez_compressed(args.out, allow_pickle=False, **arrays)


if __name__ == "__main__":
    main()
