"""Pieces of a sweep: together they have each member once, and none is empty."""

from hypothesis import example, given, strategies as st

from fivtui.sweeps.pieces import piece_count, sweep_piece


@given(st.integers(1, 500), st.integers(1, 60))
@example(12, 3)
@example(13, 3)
@example(1, 1)
@example(2, 60)
def test_pieces_are_all_members_in_order_and_only_the_last_may_be_short(
    members: int, size: int
) -> None:
    pieces = [sweep_piece(number, members, size) for number in range(piece_count(members, size))]
    assert [index for piece in pieces for index in range(piece.first, piece.stop)] == list(
        range(members)
    )
    assert [piece.number for piece in pieces] == list(range(len(pieces)))
    assert all(piece.stop - piece.first == size for piece in pieces[:-1])
    assert 1 <= pieces[-1].stop - pieces[-1].first <= size
