"""`ssmash console` and `ssmash trial`: a page on which a person drives the claw."""

from __future__ import annotations

import asyncio
import gc
from pathlib import Path
from typing import Any, Final

from rich.console import Console as Terminal

from ssmash_gym.console.form import Bases, checked
from ssmash_gym.console.programme import FreeDrive
from ssmash_gym.console.server import Console
from ssmash_gym.console.show import Rules
from ssmash_gym.console.web import Place, open_browser, require_websockets
from ssmash_gym.errors import ConfigurationError

PORT: Final = 8765
RIVAL: Final = "ppo_traverse"  # at hand for taking over, and to be compared with


def console(
    scenario: str = "ss4",
    helicopter: str = "generic_tricycle",
    task: str = "traverse",
    policy: str | None = None,
    seed: int = 1,
    out: Path = Path("runs/console"),
    port: int = PORT,
    address: str = "127.0.0.1",
    browser: bool = True,
) -> None:
    """Drive the claw yourself: open a page with the deck in 3-D, and drive by keyboard, gamepad or on-screen stick.

    Every episode is recorded in --out and can be replayed bit for bit (``ssmash replay``) and looked at again
    (``ssmash view``). One page drives; any number of others may watch. Ctrl-C ends it.

    Args:
        scenario: Name in ``configs/scenarios`` or a YAML file: ship, sea, start, what is not known exactly.
        helicopter: Name in the catalogue, or a YAML file.
        task: Name in ``configs/tasks`` or a YAML file: track, goal, limits, claw.
        policy: Scripted policy or trained agent (name or folder) that drives from the beginning, while you watch and
            may take over at any moment. Without it you drive, and the shipped agent may take over.
        seed: Of the first sea; the next one has the next number.
        out: Folder for the records.
        port: Of the server; 0 takes a free one.
        address: Where the server listens. Anything but this machine's own address lets others on the network watch
            and drive.
        browser: Open the page in the browser.

    Raises:
        ConfigurationError: A name, a file or a number is refused; nothing has been written.
        ImportError: The extra ``web`` is missing.
    """
    require_websockets()
    place = Place(address, port)
    bases = Bases(scenario=scenario, task=task, helicopter=helicopter)
    programme = FreeDrive(checked({}, {}, bases), seed, out)
    desk = Console(programme, policy=policy or RIVAL, by_policy=policy is not None, bases=bases)
    _run(desk, place, browser, f"records go to {out}")


def trial(
    participant: str,
    protocol: str = "standard",
    out: Path = Path("runs/trials"),
    experience: str | None = None,
    scripted: str | None = None,
    port: int = PORT,
    address: str = "127.0.0.1",
    browser: bool = True,
) -> None:
    """A session by protocol: practice seas until a plateau, then scored seas in a shuffled order, each once.

    A session that was stopped is gone on with by the same command. Compare participants with policies and agents by
    ``ssmash benchmark --trials runs/trials``.

    Args:
        participant: A code such as P01: letters, digits, - and _. No name: the files hold no personal data.
        protocol: Name in ``configs/trials`` or a YAML file.
        out: Folder for the records, one folder a participant.
        experience: Code of the participant's experience with such a task, such as none or pilot; asked for once.
        scripted: Let a scripted policy (operator) or an agent drive the session, without a page and faster than real
            time; its records say so everywhere.
        port: Of the server; 0 takes a free one.
        address: Where the server listens; anything but this machine's own address lets others watch and drive.
        browser: Open the page in the browser.

    Raises:
        ConfigurationError: The participant, the protocol or a number is refused; nothing has been written.
        ImportError: The extra ``web`` is missing.
    """
    from ssmash_gym.trials.protocol import load_protocol
    from ssmash_gym.trials.scripted import policy_for, run_scripted
    from ssmash_gym.trials.session import Session

    chosen = load_protocol(protocol)
    place = Place(address, port)
    if scripted is None:
        require_websockets()
    else:
        policy_for(scripted, chosen.condition)  # refused before a folder is made
    with Session.open(chosen, participant, out, experience=experience) as session:
        if session.next() is None:
            raise ConfigurationError(f"--participant {participant} is refused: this session has been finished.")
        if scripted is not None:
            run_scripted(session, scripted, told=lambda trial, path: print(f"{path}: {trial.driver}, {trial.phase}"))
            return
        rules = Rules(chosen.countdown_s, chosen.late.after_s, chosen.late.share)
        desk = Console(session, rules, policy=RIVAL, protocol=chosen.model_dump(mode="json"))
        _run(desk, place, browser, f"records go to {out / participant}")


def _run(desk: Console, place: Place, browser: bool, words: str) -> None:
    """Serve until Ctrl-C, or until a session is finished and its last page closed."""
    terminal = Terminal()

    async def serve() -> None:
        async with desk.serving(place) as port:
            url = place.url(port)
            terminal.print(f"{url}  ({words}; Ctrl-C ends)", markup=False, soft_wrap=True)
            if not place.loopback:
                terminal.print(
                    f"warning: {place.address} can be reached from the network, and whoever opens the page may drive; "
                    "gamepads work on this machine only.",
                    markup=False,
                    soft_wrap=True,
                )
            if browser:
                await asyncio.to_thread(open_browser, url)
            gc.freeze()  # what has been loaded stays: collecting it again and again would delay control steps
            await desk.finished()
            terminal.print("the session is finished")
            await desk.deserted()

    try:
        asyncio.run(serve())
    finally:
        _tell(terminal, desk)


def _tell(terminal: Any, desk: Console) -> None:
    """What was not taken, if anything was."""
    refusals = desk.site.refusals
    found = {**desk.dropped, "foreign host": refusals.hosts, "foreign page": refusals.origins}
    told = ", ".join(f"{name} {count}" for name, count in found.items() if count)
    if told:
        terminal.print(f"messages and requests that were dropped: {told}", markup=False)
