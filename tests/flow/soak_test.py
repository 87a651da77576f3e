#!/usr/bin/env python3
"""The verdict of toolchain/soak on series whose truth is known: tests/flow/soak_test.py SOAK"""
import importlib.machinery
import importlib.util
import random
import sys
import unittest

LOADER = importlib.machinery.SourceFileLoader("soak", sys.argv[1])
soak = importlib.util.module_from_spec(importlib.util.spec_from_loader("soak", LOADER))
sys.dont_write_bytecode = True
LOADER.exec_module(soak)

PAGE, CAPTURES, RUNS = 4096, 9900, 100
LEVEL = 450 * PAGE


def wandering(seed, share=0.01):
    """A page more or less every now and then, for good: no trend, and no level to come back to."""
    rng, pages, values = random.Random(seed), 450, []
    for _ in range(CAPTURES):
        if rng.random() < share:
            pages += rng.choice((-1, 1))
        values.append(pages * PAGE)
    return values


def noisy(seed, memory=0.95):
    """About one level, to which it comes back within some 20 captures."""
    rng, pages, values = random.Random(seed), 0.0, []
    for _ in range(CAPTURES):
        pages = memory * pages + rng.gauss(0, 1)
        values.append(LEVEL + round(pages) * PAGE)
    return values


def leaking(values, captures_a_page):
    return [value + i // captures_a_page * PAGE for i, value in enumerate(values)]


def share_flat(series):
    return sum(soak.is_flat(values) for values in series) / RUNS


class Trend(unittest.TestCase):
    def test_a_straight_line_has_its_slope_and_no_error(self):
        slope, error = soak.trend_of([LEVEL + 7 * i for i in range(CAPTURES)])
        self.assertAlmostEqual(slope, 7, places=6)
        self.assertLess(error, 1e-6)

    def test_the_error_is_that_of_the_mean_of_the_blocks_slopes(self):
        rising, level = [3 * i for i in range(10)], [5] * 10
        slope, error = soak.trend_of((rising + level) * (soak.BLOCKS // 2))
        self.assertAlmostEqual(slope, 1.5)
        self.assertAlmostEqual(error, 1.5 / (soak.BLOCKS - 1) ** 0.5)

    def test_a_leak_of_a_page_in_a_hundred_captures_is_told(self):
        for series in (wandering, noisy):
            self.assertLessEqual(share_flat(leaking(series(seed), 100) for seed in range(RUNS)), 0.01, series.__name__)

    def test_steps_without_trend_are_flat(self):
        for series in (wandering, noisy):
            self.assertGreaterEqual(share_flat(series(seed) for seed in range(RUNS)), 0.95, series.__name__)

    def test_one_step_and_one_flat_line_are_flat(self):
        self.assertTrue(soak.is_flat([LEVEL] * CAPTURES))
        self.assertTrue(soak.is_flat([LEVEL] * 600 + [LEVEL + 25 * PAGE] * (CAPTURES - 600)))

    def test_a_small_steady_leak_is_told_where_nothing_else_moves(self):
        self.assertFalse(soak.is_flat(leaking([LEVEL] * CAPTURES, 100)))
        self.assertFalse(soak.is_flat(leaking([LEVEL] * 100, 10)))

    def test_few_captures_may_make_four_pages(self):
        self.assertTrue(soak.is_flat(leaking([LEVEL] * 100, 25)))

    def test_few_captures_that_fall_in_every_block_and_come_back_are_flat(self):
        teeth = [LEVEL + PAGE * (i % 6 == 0) for i in range(96)]
        slope, error = soak.trend_of(teeth)
        self.assertGreater(abs(slope), soak.T_QUANTILE * error)
        self.assertTrue(soak.is_flat(teeth))
        self.assertFalse(soak.is_flat(leaking(teeth, 2)))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
