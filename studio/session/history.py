"""The history of a piece of work: undo and redo without end, and named snapshots; every operation makes a new one."""

from __future__ import annotations

from dataclasses import dataclass, replace

from msgspec import structs

from studio.session.state import State


@dataclass(frozen=True)
class History:
    """States in the order in which they were made, the number of the current one, and snapshots by name.

    >>> history = History().step(State("draw")).step(State("keep"))
    >>> history.undone().now.step, history.undone().redone().now.step
    ('draw', 'keep')
    """

    states: tuple[State, ...] = (State(),)
    current: int = 0
    snapshots: tuple[tuple[str, State], ...] = ()

    @property
    def now(self) -> State:
        """The state that is shown."""
        return self.states[self.current]

    @property
    def undo(self) -> str | None:
        """What undo would take back; None at the start."""
        return self.now.step if self.current > 0 else None

    @property
    def redo(self) -> str | None:
        """What redo would do again; None at the end."""
        return self.states[self.current + 1].step if self.current + 1 < len(self.states) else None

    def step(self, state: State) -> History:
        """Add a state after the current one; what was undone is forgotten."""
        return replace(self, states=(*self.states[: self.current + 1], state), current=self.current + 1)

    def undone(self) -> History:
        """Go back a step, if there is one."""
        return replace(self, current=max(0, self.current - 1))

    def redone(self) -> History:
        """Go forward a step, if one was undone."""
        return replace(self, current=min(len(self.states) - 1, self.current + 1))

    def settled(self, before: State, after: State) -> History:
        """Complete a state with what was computed for it, wherever in the history it is now.

        >>> state = State("draw")
        >>> History().step(state).undone().settled(state, State("draw", shown="1f")).redone().now.shown
        '1f'
        """
        return replace(
            self,
            states=tuple(after if state is before else state for state in self.states),
            snapshots=tuple((name, after if state is before else state) for name, state in self.snapshots),
        )

    def snapshot(self, name: str) -> History:
        """Keep the current state under a name; an older snapshot of that name goes."""
        return replace(self.forgotten(name), snapshots=(*self.forgotten(name).snapshots, (name, self.now)))

    def forgotten(self, name: str) -> History:
        """Delete a snapshot."""
        return replace(self, snapshots=tuple(kept for kept in self.snapshots if kept[0] != name))

    def restored(self, name: str) -> History:
        """Go to the state of a snapshot as a new step; KeyError if there is none of that name.

        >>> History().snapshot("first").step(State("draw")).restored("first").undo
        'restore first'
        """
        state = dict(self.snapshots)[name]
        return self.step(structs.replace(state, step=f"restore {name}"))
