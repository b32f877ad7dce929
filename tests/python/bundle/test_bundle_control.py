"""raylign.bundle.adjust: callback, stop, Ctrl-C, limits."""

import os
import signal
import threading

import numpy as np
import pytest

import oracle
from raylign.bundle import BundleOptions, LmOptions, Termination


def test_callback_sees_every_iteration_in_order(adjust, perturbed):
    seen = []
    summary = adjust(perturbed, callback=lambda it: seen.append((it.iteration, it.cost))).summary
    assert seen == list(
        zip(summary.iterations["iteration"], summary.iterations["cost"], strict=True)
    )


@pytest.mark.parametrize("boolean", [bool, np.bool_])
def test_callback_returning_false_stops_with_the_best_state(adjust, perturbed, boolean):
    result = adjust(perturbed, callback=lambda it: boolean(it.iteration < 2))
    assert result.summary.termination is Termination.USER_STOPPED
    assert len(result.summary.iterations) == 3
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)
    assert result.summary.final_cost < result.summary.initial_cost


@pytest.mark.parametrize("answer", [None, True, 0, 1, "stop"])
def test_only_false_stops(adjust, perturbed, answer):
    summary = adjust(perturbed, callback=lambda it: answer).summary
    assert summary.termination is Termination.CONVERGENCE


def test_exception_in_the_callback_comes_out(adjust, perturbed):
    class MineError(Exception):
        pass

    def callback(iteration):
        if iteration.iteration == 1:
            raise MineError("from the callback")

    before = perturbed.copy()
    with pytest.raises(MineError, match="from the callback"):
        adjust(perturbed, callback=callback)
    assert perturbed == before


def test_ctrl_c_stops_with_the_best_state(adjust, perturbed):
    def callback(iteration):
        if iteration.iteration == 1:
            os.kill(os.getpid(), signal.SIGINT)

    result = adjust(perturbed, callback=callback)
    assert result.summary.termination is Termination.USER_STOPPED
    assert result.summary.final_cost < result.summary.initial_cost
    assert result.summary.final_cost == pytest.approx(oracle.cost(result.problem), rel=1e-12)


def test_keyboard_interrupt_raised_by_the_callback_is_a_stop(adjust, perturbed):
    def callback(iteration):
        raise KeyboardInterrupt

    assert adjust(perturbed, callback=callback).summary.termination is Termination.USER_STOPPED


def test_other_threads_run_during_a_solve(adjust, perturbed):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(1)
            stop.wait(1e-4)

    thread = threading.Thread(target=tick)
    thread.start()
    seen = []
    try:
        while sum(seen) == 0 and len(seen) < 2000:  # one takes less than a tick
            before = len(ticks)
            adjust(perturbed)
            seen.append(len(ticks) - before)
    finally:
        stop.set()
        thread.join()
    assert sum(seen) > 0


def test_zero_iterations_only_evaluate(adjust, perturbed):
    result = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_num_iterations=0)))
    assert result.problem == perturbed
    assert result.summary.termination is Termination.MAX_ITERATIONS
    assert result.summary.final_cost == result.summary.initial_cost
    assert len(result.summary.iterations) == 1


def test_iteration_and_time_limits_are_told_apart(adjust, perturbed):
    few = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_num_iterations=1))).summary
    assert few.termination is Termination.MAX_ITERATIONS
    late = adjust(perturbed, options=BundleOptions(lm=LmOptions(max_solver_time_s=1e-9))).summary
    assert late.termination is Termination.TIME_LIMIT
    assert late.final_cost <= late.initial_cost
