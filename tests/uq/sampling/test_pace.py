"""What is told while a posterior is sampled whose length nobody knows beforehand."""

from haptid.uq.sampling.pace import Pace


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def told_by(taus: list[float], *, read: int = 0) -> list[tuple[float | None, str]]:
    """Chunks of 50 steps and 10 s each, with the τ that each tells; the first ``read`` come from an earlier command."""
    told: list[tuple[float | None, str]] = []
    clock = Clock()
    pace = Pace(tell=lambda share, words: told.append((share, words)), most=5000, now=clock)
    for number, tau in enumerate(taus):
        watch = pace.begin_chunk(50, 0 if number < read else 2)
        if number >= read:
            clock.now += 5.0
            watch(0, 1.0, "")
            clock.now += 5.0
        pace.end_chunk(50, read=number < read)
        pace.learn(max(50 * tau - 50 * (number + 1), 50), tau, 100.0)
    pace.end_chunk(50, read=False)
    return told


def test_no_share_is_told_while_the_autocorrelation_time_grows():
    """The share went 28, 30, 33, 38, 37 %, and the time left from 19 to 30 minutes."""
    told = told_by([5.0, 10.0, 20.0, 30.0])
    assert [share for share, _ in told] == [None] * len(told)
    words = [words for _, words in told]
    assert words[0] == "step 25 of at most 5000, at most 16:35 left"
    # Two ensembles, 50 steps in 10 s: 150 done, 50·30 asked for by the last τ.
    assert words[-1] == "step 250 of at most 5000, 3:20 to 12:40 left, τ 30.0 and growing, ESS 100"


def test_the_share_never_falls_once_the_autocorrelation_time_has_settled():
    told = told_by([10.0, 10.0, 10.4, 10.8, 10.9, 11.0])
    shares = [share for share, _ in told if share is not None]
    assert len(shares) == 9
    assert shares == sorted(shares)
    assert told[-1][1] == "step 350 of about 550, τ 11.0, ESS 100"


def test_chunks_of_an_earlier_command_tell_no_pace():
    words = [words for _, words in told_by([10.0, 20.0, 40.0], read=2)]
    assert words[0] == "step 50 of at most 5000"
    assert words[2] == "step 125 of at most 5000, 2:55 to 16:15 left, τ 20.0 and growing, ESS 100"
