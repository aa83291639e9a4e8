"""Sessions: the mesh of each update is that of an extraction, and the arrays follow."""
import copy
import gc
import math
import pickle
import signal
import threading
import unittest

from support import built, check_mesh

import numpy as np
import ptet

REQUESTS = [
    {"error": "5%"}, {"budget": 300}, {"focus": ptet.Sphere((0, 0, 0), 0.4)}, {"focus": ptet.Sphere((1, 1, 1), 0.4)},
    {}, {"error": "30%"}, {"error": "1%", "domain_error": "1%"}, {"error": "4%", "values": ptet.Values("t", 1.2)},
    {"budget": 40}, {},
]


def without_slots(session):
    """points, tets, boundary faces and vertex ids of what the arrays show."""
    ids, tets, faces = session.vertex_ids, session.tets, session.boundary_faces
    used = np.flatnonzero(ids != ptet.UNUSED)
    row = np.full(len(ids), -1, np.int64)
    row[used] = np.arange(len(used))
    return (session.points[used], row[tets[tets[:, 0] != ptet.UNUSED]], row[faces[faces[:, 0] != ptet.UNUSED]],
            ids[used], {name: values[used] for name, values in session.fields.items()})


def carried_on(tets, update, session):
    """A copy by slots, with those that changed taken anew."""
    grown = np.zeros((len(session.tets), 4), np.uint32)
    grown[:len(tets)] = tets[:len(grown)]
    grown[update.changed_tets] = session.tets[update.changed_tets]
    return grown


def as_ids(ids, rows):
    """Rows by vertex ids, each from its least corner on, sorted: what two numberings of one mesh have in common."""
    return sorted(sorted(row) for row in ids[rows].tolist())


class Session(unittest.TestCase):
    def check_same(self, session, cut):
        points, tets, faces, ids, fields = without_slots(session)
        check_mesh(self, points, tets, faces)
        self.assertEqual(as_ids(ids, tets), as_ids(cut.vertex_ids, cut.tets))
        self.assertEqual(as_ids(ids, faces), as_ids(cut.vertex_ids, cut.boundary_faces))
        here, there = np.argsort(ids), np.argsort(cut.vertex_ids)
        np.testing.assert_array_equal(points[here], cut.points[there])
        for name, values in fields.items():
            np.testing.assert_array_equal(values[here], cut.fields[name][there])

    def test_each_update_is_the_extraction(self):
        data = ptet.open(built())
        session = data.session()
        self.assertEqual(len(without_slots(session)[1]), data.info.base_tets)
        tets, vertices = 0, 0
        for request in REQUESTS:
            with self.subTest(request):
                update, cut = session.update(**request), data.extract(**request)
                self.assertTrue(update.complete)
                self.assertEqual((update.tets, update.vertices, update.boundary_faces),
                                 (len(cut.tets), len(cut.points), len(cut.boundary_faces)))
                tets += update.tets_added - update.tets_removed
                vertices += update.vertices_added - update.vertices_removed
                self.assertEqual((update.tets, update.vertices), (tets, vertices))
                self.assertEqual(update.field_error, cut.field_error)
                self.assertEqual(update.rms_error.keys(), cut.rms_error.keys())
                self.assertEqual(update.covered, cut.covered)
                self.assertEqual(update.limited_by, cut.limited_by)
                self.check_same(session, cut)
                np.testing.assert_array_equal(session.extraction().tets, cut.tets)

    def test_changed_slots_keep_a_copy_right(self):
        session = ptet.open(built()).session()
        tets = np.empty((0, 4), np.uint32)
        for request in REQUESTS:
            update = session.update(**request)
            tets = carried_on(tets, update, session)
            np.testing.assert_array_equal(tets, session.tets)
            self.assertEqual(len(set(update.changed_tets.tolist())), len(update.changed_tets))

    def test_changes_of_an_interrupted_update_are_told_by_the_next(self):
        class Interrupted:
            def __init__(self, core):
                self.core = core

            def __getattr__(self, name):
                return getattr(self.core, name)

            def update(self, request, progress):
                self.core.update(request, progress)
                raise KeyboardInterrupt

        session = ptet.open(built()).session()
        session.update(error="20%")
        held = session.tets.copy()
        core, session._core = session._core, Interrupted(session._core)
        with self.assertRaises(KeyboardInterrupt):
            session.update(origins=True)
        session._core = core
        wanted = ptet.open(built()).extract(origins=True)
        np.testing.assert_array_equal(session.extraction().tets, wanted.tets)
        np.testing.assert_array_equal(session.extraction().made_by, wanted.made_by)
        for _ in range(2):  # refused, it changes nothing of that
            with self.assertRaises(ptet.ArgumentError):
                session.update(error={"nothing": "1%"})
        update = session.update()
        self.assertTrue(update.renumbered)
        np.testing.assert_array_equal(carried_on(held, update, session), session.tets)
        for name, rows in (("faces", session.boundary_faces), ("vertices", session.vertex_ids)):
            np.testing.assert_array_equal(getattr(update, "changed_" + name), np.arange(len(rows)))
        self.assertFalse(session.update().renumbered)

    def test_sessions_are_not_copied(self):
        session = ptet.open(built()).session()
        for use in (copy.copy, copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "neither copied nor pickled"):
                use(session)

    def test_origins_follow_as_long_as_they_are_asked_for(self):
        data = ptet.open(built())
        session = data.session()
        self.assertIsNone(session.made_by)
        for step, request in enumerate(REQUESTS):
            with self.subTest(request):
                origins = step % 4 != 3
                session.update(**request, origins=origins)
                if not origins:
                    self.assertIsNone(session.made_by)
                    continue
                cut = data.extract(**request, origins=True)
                tets, made_by = session.tets, session.made_by
                self.assertEqual(made_by.shape, (len(tets),))
                used = tets[:, 0] != ptet.UNUSED
                self.assertTrue((made_by[~used] == ptet.UNUSED).all())
                ids = np.sort(session.vertex_ids[tets[used]], axis=1)
                mine = np.column_stack([ids, made_by[used]]).tolist()
                wanted = np.column_stack([np.sort(cut.vertex_ids[cut.tets], axis=1), cut.made_by]).tolist()
                self.assertEqual(sorted(mine), sorted(wanted))
                np.testing.assert_array_equal(session.extraction().made_by, cut.made_by)
                errors = data.origin_values(made_by, "field error", "t")
                self.assertEqual(errors.max(), cut.field_error["t"])
                levels = data.origin_values(made_by, "level")
                np.testing.assert_array_equal(levels == 0, made_by == ptet.UNUSED)
                self.assertTrue((data.origin_values(made_by, "generation") >= 0).all())
        for wrong in (("size",), ("field error",), ("field error", "nothing")):
            with self.assertRaises(ptet.ArgumentError):
                data.origin_values([0], *wrong)
        with self.assertRaises(ptet.ArgumentError):
            data.origin_values([ptet.UNUSED - 1], "level")

    def test_nothing_changes_for_the_same_request(self):
        session = ptet.open(built()).session()
        session.update(error="5%")
        update = session.update(error="5%")
        self.assertEqual((update.splits, update.collapses, len(update.changed_tets)), (0, 0, 0))

    def test_arrays_outlive_the_session(self):
        session = ptet.open(built()).session()
        session.update(budget=200)
        old = session.points
        copy = old.copy()
        session.update()
        new, tets = session.points, session.tets
        self.assertGreater(len(new), len(old))
        wanted = new.copy(), tets.copy()
        del session
        gc.collect()
        np.ones(10**6)
        self.assertEqual(old.shape, copy.shape)
        np.testing.assert_array_equal(new, wanted[0])
        np.testing.assert_array_equal(tets, wanted[1])
        with self.assertRaises(ValueError):
            new[0] = 0

    def test_time_has_an_end(self):
        with self.assertRaises(ptet.ArgumentError):
            ptet.open(built(), ).session().update(budget=ptet.Budget(milliseconds=math.inf))

    def test_little_time_leads_to_the_same_mesh(self):
        data = ptet.open(built(), )
        session, calls, done = data.session(), 0, 0
        while True:
            update = session.update(error="1%", budget=ptet.Budget(milliseconds=0))
            calls += 1
            done += update.splits
            if update.complete:
                break
            self.assertEqual(update.limited_by, "time")
            check_mesh(self, *without_slots(session)[:3])
        self.assertGreater(calls, 2)
        self.check_same(session, data.extract(error="1%"))

    def test_refusals_leave_the_mesh(self):
        data = ptet.open(built())
        session = data.session()
        session.update(error="5%")
        tets = session.tets.copy()
        for request in ({"error": -1}, {"error": {"nothing": 1}}, {"focus": ptet.Sphere((0, 0, 0), -1)}):
            with self.assertRaises(ptet.ArgumentError):
                session.update(**request)
        np.testing.assert_array_equal(session.tets, tets)
        self.check_same(session, data.extract(error="5%"))
        with self.assertRaises(ptet.ArgumentError):
            ptet.Session(3)

    def test_cancelled_updates_leave_the_mesh(self):
        data = ptet.open(built())
        session = data.session()
        session.update(error="20%")
        told = []

        def cancel(*what):
            told.append(what)
            return False

        with self.assertRaises(ptet.Cancelled):
            session.update(error="5%", progress=cancel)
        self.assertEqual(told, [("reading", 0, 0)])
        self.check_same(session, data.extract(error="20%"))
        with self.assertRaises(ZeroDivisionError):
            session.update(error="5%", progress=lambda *_: 1 // 0)
        with self.assertRaisesRegex(ptet.ArgumentError, "called"):
            session.update(error="5%", progress=3)
        self.check_same(session, data.extract(error="20%"))
        with self.assertRaises(ptet.ArgumentError):
            session.update(error="5%", progress=lambda *_: data.extract(error=-1))
        self.assertTrue(session.update(error="5%", progress=lambda *_: None).renumbered)
        self.check_same(session, data.extract(error="5%"))

    def test_what_is_raised_amid_an_update_is_told_by_the_next(self):
        """Of a progress too, whatever it raises."""
        data = ptet.open(built())
        session = data.session()
        session.update(error="30%")
        held = session.tets.copy()
        core, calls = session._core, []

        class Slowly:
            def __getattr__(self, name):
                return getattr(core, name)

            def update(self, request, progress):
                step = core.update(request, progress)
                step["limited_by"] = "time"  # as after a slice
                return step

        def third(*_):
            calls.append(1)
            if len(calls) == 3:
                raise ptet.ArgumentError("of its own")

        session._core = Slowly()
        with self.assertRaisesRegex(ptet.ArgumentError, "of its own"):
            session.update(error="1%", progress=third)
        session._core = core
        update = session.update(error="3%")
        self.assertTrue(update.renumbered)
        np.testing.assert_array_equal(carried_on(held, update, session), session.tets)
        self.check_same(session, data.extract(error="3%"))

    def test_one_thread_at_a_time(self):
        class Slow:
            """Stops in the middle of a read until it is told to go on."""
            size = len(built())

            def __init__(self):
                self.waits, self.go_on, self.is_slow = threading.Event(), threading.Event(), False

            def read(self, offset, size):
                if self.is_slow:
                    self.waits.set()
                    self.go_on.wait(60)
                return built()[offset:offset + size]

        source = Slow()
        data = ptet.open(source)
        session = data.session()
        source.is_slow = True
        updates = []
        thread = threading.Thread(target=lambda: updates.append(session.update(error="1%")))
        thread.start()
        self.assertTrue(source.waits.wait(60))
        for use in (session.update, session.extraction, lambda: session.tets):
            with self.assertRaisesRegex(ptet.Error, "another thread"):
                use()
        source.is_slow = False
        source.go_on.set()
        thread.join()
        self.assertTrue(updates[0].complete)
        self.check_same(session, data.extract(error="1%"))

    def test_interrupted_arrays_catch_up(self):
        """A signal between the library's update and the arrays'."""
        class Own(Exception):
            pass

        def interrupt(*_):
            raise Own

        data = ptet.open(built())
        session = data.session()
        session.update(error="20%")
        before = signal.signal(signal.SIGALRM, interrupt)
        try:
            follow = session._follow
            session._follow = lambda step: signal.raise_signal(signal.SIGALRM)
            with self.assertRaises(Own):
                session.update(error="1%")
            session._follow = follow
        finally:
            signal.signal(signal.SIGALRM, before)
        self.check_same(session, data.extract(error="1%"))
        session.update(error="3%")
        self.check_same(session, data.extract(error="3%"))


if __name__ == "__main__":
    unittest.main()
