"""Noise, numbers of the drive, instruments and effects in one competition.

compete  screen, fit, weigh -> Competition

Order: the setting (a first fit of the drive as stated, readings that scatter more, the library at a
glance); single effects that may matter, and the pairs and triples that the linear search offers (of
a torsion spring also two to four large effects at once), fitted in full; sets of one effect more,
less or another than the best; shapes and usual forms once more; lack of fit that no effect names,
on top of the best and in place of some of its effects. All are weighed by evidence and prior odds,
so no order of asking decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, count

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.crew import Crew, Task, side_by_side
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter, Race
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import ODDS
from cbpt.lab.selection.competition import Competition, Progress
from cbpt.lab.selection.effort import EFFORT
from cbpt.lab.selection.lack_of_fit import LackOfFit, lacks_of_fit_on, says_no_more
from cbpt.lab.selection.linear_screen import Screen
from cbpt.lab.selection.linear_search import (
    Offer,
    additions_to,
    leaders,
    promising_singles,
    set_offers,
    single_offers,
    variant_prices,
    views,
    with_a_part,
)
from cbpt.lab.selection.refits import (
    again,
    fitting,
    follows,
    in_usual_forms,
    is_odd,
    kind_of,
    modes_of,
    ranking,
    shapes_of,
    stripped,
    without_idle,
)
from cbpt.lab.selection.setting import (
    Names,
    Setting,
    plain,
    prepare,
    prior,
    with_an_artefact,
)
from cbpt.lab.selection.starts import refitted, start_values, starts_at_once

Floats = NDArray[np.float64]


_TIE = 1e-6
"""In log odds: fits nearer than this are equally good, and the first of them stands."""


def compete(
    campaign: Campaign, rng: np.random.Generator, progress: Progress | None = None
) -> Competition:
    """Fit and weigh everything. The model must have a solution at every row."""
    report = progress or (lambda what, share: None)
    report("the drive as stated", 0.0)
    contest = _Contest(prepare(Fitter(campaign)), report)
    contest.fit_singles()
    contest.find_modes()
    contest.fit_sets()
    contest.add_to_curved()
    contest.find_modes_of_sets()
    if contest.are_large:
        contest.fit_together()
    contest.add_drop_swap()
    contest.settle()
    report("lack of fit", 0.85)
    contest.ask_the_instrument()
    contest.find_modes_of_best()
    contest.share_noise()
    contest.settle()
    contest.find_forms()
    contest.settle()  # each set with what was found last
    unnamed = contest.unnamed()
    report("p-values by simulation", 0.95)
    return contest.competition(unnamed, rng)


class _Contest:
    """The fits so far, and the steps that add to them."""

    def __init__(self, setting: Setting, report: Progress) -> None:
        self.report, self.fitter = report, setting.fitter
        self.crew = Crew(setting.fitter)
        self.views = views(setting)
        self.singles = single_offers(self.views)
        self.setting = replace(setting, variant_price=variant_prices(setting, self.singles))
        self.fits: dict[Names, Fit] = {(): setting.null}
        """The best fit of every set of effects so far."""

    def keep(self, fit: Fit | None) -> None:
        """Keep a fit where it is the best of its set, without the effects that it put to
        nothing."""
        fit = without_idle(self.fitter, fit)
        if fit is None or not np.isfinite(fit.log_evidence):
            return
        names = fit.hypothesis.effects
        if names not in self.fits or fit.log_evidence > self.fits[names].log_evidence + _TIE:
            self.fits[names] = fit

    def keep_instead(self, fit: Fit | None) -> None:
        """Keep a fit in place of the ranked one of its set, even where that one seemed better."""
        if fit is not None:
            self.fits.pop(fit.hypothesis.effects, None)
            self.keep(fit)

    def score(self, names: Names) -> float:
        """Log of evidence times prior odds."""
        return self.setting.score(self.fits[names])

    @property
    def are_large(self) -> bool:
        """Whether effects may be as large as the angle itself: play and friction of a spring."""
        return self.fitter.campaign.drive.kind == "torsion_spring"

    # --- steps ---

    def fit_singles(self) -> None:
        """Every effect that may gain, in its most probable variants."""
        promising = promising_singles(
            self.singles, EFFORT.singles, EFFORT.single_room, EFFORT.variant_room
        )
        near = self.singles[0].score - EFFORT.modes_room if self.singles else 0.0
        many = [forms for forms in promising.values() if forms[0].score > near]
        few = [forms for forms in promising.values() if forms[0].score <= near]
        offers = self.ahead(many, EFFORT.variants)
        offers += [offer for forms in few for offer in forms[: EFFORT.variants]]
        tasks = [(o.names[0], task) for o in offers for task in self.single(o)]
        self.fit_all(tasks, (0.1, 0.5))
        self.crew.each((task for o in self.misjudged(offers) for task in self.single(o)), self.keep)

    def misjudged(self, fitted: Sequence[Offer]) -> Iterator[Offer]:
        """Forms of the best single effect that fell behind by no more than the linear problem is
        off, which is the more, the larger an effect is."""
        top = max(self.fits, key=self.score)
        if own := [o for o in self.singles if o.names == top]:
            off = abs(self.score(top) - own[0].score)
            near = [o for o in own if o not in fitted and o.score > own[0].score - off]
            yield from near[: EFFORT.variants]

    def fit_all(
        self, tasks: Sequence[tuple[str, Task[Fit | None]]], shares: tuple[float, float]
    ) -> None:
        """Keeps what becomes of tasks, each with a word for it, and tells which is next, between
        two shares of the work."""
        first, last = shares
        words = [word for word, _ in tasks]
        done = count(1)

        def take(fit: Fit | None) -> None:
            self.keep(fit)
            number = next(done)
            done_of_it = number / len(words)
            share = first * (1 - done_of_it) + last * done_of_it
            self.report(words[min(number, len(words) - 1)], share)

        for word in words[:1]:
            self.report(word, first)
        self.crew.each((task for _, task in tasks), take)

    def single(self, offer: Offer) -> Iterator[Task[Fit | None]]:
        """The fits of one effect alone."""
        yield self.fit_of(offer)
        if self.are_large:
            # Through correlated noise a fit may not find its way to them.
            hypothesis = Hypothesis((offer.signatures[0].variant,))
            start = start_values(self.fitter, offer.signatures, offer.sizes)
            yield fitting(hypothesis, start, self.setting.plain)

    def fit_of(self, offer: Offer) -> Task[Fit | None]:
        """The full fit of a set that the linear search offers."""
        base = offer.base or self.setting.null
        return lambda fitter: fitter.fit(*self.begun(offer), offer.noise, base=base)

    def begun(self, offer: Offer) -> tuple[Hypothesis, Floats]:
        """What is offered, and the values to begin with."""
        before = offer.base.hypothesis.variants if offer.base else ()
        hypothesis = Hypothesis((*before, *(s.variant for s in offer.signatures)))
        start = start_values(self.fitter, offer.signatures, offer.sizes, offer.base)
        return hypothesis, refitted(self.fitter, offer.seen, offer.signatures, start)

    def find_modes(self) -> None:
        """Other modes of the singles that are near the best; and of one that does not grow in
        proportion to its size, whose fit may have ended at nothing, by form."""
        near = self.near_best()
        self.put(near, [modes_of(self.fits[names]) for names in near])
        best, tasks = self.fits[max(self.fits, key=self.score)], []
        for names in [n for n in self.fits if n not in near]:
            curved = any(v.secants for v in self.fits[names].hypothesis.variants)
            forms = [v for v in self.fitter.variants if curved and v.effect in names]
            tasks += [modes_of(self.fits[names], [form], best) for form in forms]
        self.crew.each(tasks, lambda fit: self.keep(replace(fit, modes_searched=False)))

    def add_to_curved(self) -> None:
        """What goes with an effect that does not grow in proportion to its size, about its fit.

        About the drive as stated the numbers of the drive stand in for both, far from where they
        are beside both, and the linear problem may see nothing of either.
        """
        best = max(self.fits, key=self.score)
        least = self.score(best) - EFFORT.settled_room
        for names in [n for n in self.fits if len(n) == 1 and best and self.score(n) > least]:
            fit = self.fits[names]
            if any(v.secants for v in fit.hypothesis.variants):
                offers = (forms[0] for forms in additions_to(self.setting, fit))
                near = self.score(names) - EFFORT.room
                fresh = [o for o in offers if o.score > near and self.falls_short(o)]
                self.crew.each(map(self.fit_of, fresh[: EFFORT.curved]), self.keep)

    def find_modes_of_sets(self) -> None:
        """The same of sets with an effect that does not grow in proportion to its size, in the
        form that it has: which of its peaks the fit ends at depends on where it begins."""
        curved = {
            names: forms
            for names in sorted(self.near_best(), key=self.score, reverse=True)
            if len(names) > 1
            and (forms := [v for v in self.fits[names].hypothesis.variants if v.secants])
            and self.has_a_part(names)
        }
        few = list(curved)[: EFFORT.curved]
        self.put(few, [modes_of(self.fits[names], curved[names]) for names in few])
        for names in few:
            # In other forms, and of other effects, none were.
            self.fits[names] = replace(self.fits[names], modes_searched=False)

    def put(self, names: Sequence[Names], tasks: Sequence[Task[Fit]]) -> None:
        """The fits of some sets by what becomes of a task each."""
        found: list[Fit] = []
        self.crew.each(tasks, found.append)
        self.fits.update(zip(names, found, strict=True))

    def near_best(self) -> list[Names]:
        """Sets near the best that are better than the drive as stated."""
        best = max(self.score(n) for n in self.fits) - EFFORT.modes_room
        least = max(best, self.setting.score(self.setting.null))
        return [n for n in self.fits if self.score(n) > least]

    def has_a_part(self, names: Names) -> bool:
        """Whether no set within a set is worth as much: it has no effect for a passenger."""
        inner = (p for size in range(1, len(names)) for p in combinations(names, size))
        return all(self.score(p) < self.score(names) for p in inner if p in self.fits)

    def fit_sets(self) -> None:
        """Pairs and triples that may beat every single one."""
        self.report("sets of effects", 0.5)
        offers = set_offers(self.views, len(self.setting.signatures))
        fitted = max(self.score(n) for n in self.fits) - EFFORT.settled_room
        top = {
            # What a lot promises, which can be any function, is no measure of the others.
            lot: max((o.score for o in offers if o.has_lot == lot), default=0.0)
            for lot in (False, True)
        }
        # Of one effect that says nearly all and anything else there are more sets than are fitted;
        # the best of them come up again as additions to it. Before them come sets of effects that
        # need one another, and first those that may be worth far more than the linear problem
        # sees: how an effect that does not grow in proportion changes another it leaves out.
        parted = dict(zip(offers, with_a_part(offers, self.singles), strict=True))
        near = []
        for offer, has_part in parted.items():
            room = EFFORT.curved_room if has_part and offer.curved else EFFORT.room
            if offer.score > max(top[offer.has_lot] - room, fitted):
                near.append(offer)
        near.sort(key=lambda o: (not parted[o], not (parted[o] and o.curved)))
        near = [near[i] for i in leaders([o.has_lot for o in near], EFFORT.sets)]
        self.fit_all([("sets of effects", self.fit_of(offer)) for offer in near], (0.5, 0.65))
        # What a triple follows, one of its pairs may follow as well.
        best = max(self.score(n) for n in self.fits) - EFFORT.room
        for names in [n for n in self.fits if len(n) > 2 and self.score(n) > best]:
            self.drop(names)

    def add_drop_swap(self) -> None:
        """One effect more, less or another than the best sets have, until nothing gains."""
        done: set[Names] = set()
        # Of effects as large as the loop the best set may be one of another valley.
        room = EFFORT.settled_room if self.are_large else EFFORT.room
        while (number := self.rounds_of(done)) < EFFORT.rounds:
            self.report("one effect more, less or another", 0.65 + 0.2 * number / EFFORT.rounds)
            open_ = [n for n in self.fits if n not in done and n and len(n) <= EFFORT.most]
            base = max(open_, key=self.score, default=None)
            best = max(self.score(n) for n in self.fits)
            if base is None or self.score(base) < best - room:
                return
            done.add(base)
            fit = self.fits[base]
            self.drop(base)
            if len(base) < EFFORT.most:
                self.fit_near(additions_to(self.setting, fit))
            if self.score(base) == best:
                self.reshape(base)
                for gone in base if len(base) > 1 else ():
                    rest = self.fits.get(tuple(n for n in base if n != gone))
                    # None where the fit put another of its effects to nothing.
                    if rest is not None:
                        self.fit_near(additions_to(self.setting, rest, (fit.noise,)))

    def rounds_of(self, done: set[Names]) -> int:
        """How many sets count as tried; of large effects those that something was added to."""
        return sum(not self.are_large or len(names) < EFFORT.most for names in done)

    def fit_near(self, offers: Sequence[Sequence[Offer]]) -> None:
        """The best offers, each in all of its forms, that may come near the best fit and are not
        fitted yet, or fitted to less than is offered now.

        Where the best set is among the offers, it is what it was offered at that counts: a search
        finds shapes that the grid of the linear problem does not have.
        """
        best = max(self.fits, key=self.score)
        of_best = (forms[0].score for forms in offers if forms[0].names == best)
        least = min(self.score(best), next(of_best, np.inf)) - EFFORT.room
        fresh = [o for o in offers if o[0].score > least and self.falls_short(o[0])]
        chosen = self.ahead(fresh[: EFFORT.additions], 1)
        self.crew.each(map(self.fit_of, chosen), self.keep)

    def ahead(self, effects: Sequence[Sequence[Offer]], few: int) -> list[Offer]:
        """Of each effect the first few forms; of many those that are ahead once each is fitted
        under the noise of the offer, because the linear problem cannot tell forms that hardly show
        when small."""
        many = [forms for forms in effects if len(forms) > EFFORT.variants]
        found: list[Sequence[Offer]] = []
        self.crew.each((partial(self.raced, forms=forms) for forms in many), found.append)
        raced = iter(found)
        chosen = [next(raced) if len(f) > EFFORT.variants else f[:few] for f in effects]
        return [offer for offers in chosen for offer in offers]

    def raced(self, fitter: Fitter, forms: Sequence[Offer]) -> Sequence[Offer]:
        """The forms that are ahead."""
        race = Race(fitter, forms[0].noise)
        misfit = []
        for offer in forms:
            base = offer.base or self.setting.null
            fit = race.fit(*self.begun(offer), free_noise=False, base=base)
            misfit.append(np.inf if fit is None else fit.reached)
        return [forms[i] for i in np.argsort(misfit)[: EFFORT.variants - 1].tolist()]

    def falls_short(self, offer: Offer) -> bool:
        """Whether no fit of a set is near what is offered."""
        known = self.fits.get(offer.names)
        if known is None:
            return True
        # What gains nothing over what it is added to is no more than its base, however it ends.
        gains = offer.base is not None and offer.score > self.setting.score(offer.base)
        room = EFFORT.worse if gains else EFFORT.room
        return self.setting.score(known) < offer.score - room

    def drop(self, names: Names, again: bool = False) -> None:
        """All sets of one effect less than a set; `again`: those that are fitted too, from its
        values and its noise."""
        fit = self.fits[names]
        tasks = []
        for gone in names:
            rest = tuple(v for v in fit.hypothesis.variants if v.effect != gone)
            if again or tuple(sorted(v.effect for v in rest)) not in self.fits:
                start = self.fitter.start(Hypothesis(rest), {})
                kept = [u.index for u in fit.unknowns if u.name.partition(".")[0] != gone]
                start[kept] = fit.point.values[kept]
                tasks.append(fitting(Hypothesis(rest), start, fit.noise))
        self.crew.each(tasks, self.keep)

    def reshape(self, names: Names) -> None:
        """A set without one effect, another in the form that then does best: one form may do what
        two effects did. Of a pair single effects are left, fitted in their forms before."""
        if len(names) < 3:
            return
        for less in combinations(names, len(names) - 1):
            if less in self.fits:
                self.drop(less)
        for two in combinations(names, 2):
            rest = self.fits.get(tuple(n for n in names if n not in two))
            if rest is None:
                continue
            offers = additions_to(self.setting, rest, (self.fits[names].noise,))
            of_two = (forms for forms in offers if forms[0].adds in two)
            other = [[o for o in forms if not self.has_form(o)] for forms in of_two]
            self.crew.each(map(self.fit_of, self.ahead([o for o in other if o], 1)), self.keep)

    def has_form(self, offer: Offer) -> bool:
        """Whether the fit of a set has what is offered in the same form."""
        known = self.fits.get(offer.names)
        return known is not None and offer.signatures[-1].variant in known.hypothesis.variants

    def settle(self) -> None:
        """No set may owe its place to values or a noise that another has not been tried with."""
        for _ in range(EFFORT.most):
            before = dict(self.fits)
            self.lift()
            self.drop(max(self.fits, key=self.score), again=True)
            if self.fits == before:
                return

    def lift(self) -> None:
        """No set may follow the readings worse than one that it contains: such a fit has ended in
        another mode, and begins again from the values and the noise of the smaller set."""
        best = max(self.score(n) for n in self.fits)
        for names in sorted(self.fits, key=len):
            fit = self.fits[names]
            inner = [tuple(n for n in names if n != gone) for gone in names]
            fitted = [n for n in inner if n in self.fits]
            if not fitted:
                continue
            below = max(fitted, key=lambda n: follows(self.fitter, self.fits[n]))
            # What ended elsewhere may be far behind, and no less worth another start.
            if max(self.score(names), self.score(below)) < best - EFFORT.settled_room:
                continue
            smaller = self.fits[below]
            least = follows(self.fitter, smaller) - EFFORT.worse
            if follows(self.fitter, fit) < least:
                # In the forms of the smaller set, whose values these are.
                more = (v for v in fit.hypothesis.variants if v.effect not in below)
                hypothesis = Hypothesis((*smaller.hypothesis.variants, *more))
                start = self.fitter.start(hypothesis, {})
                kept = [u.index for u in smaller.unknowns]
                start[kept] = smaller.point.values[kept]
                found = self.fitter.fit(hypothesis, start, smaller.noise)
                self.keep(found)
                bare = without_idle(self.fitter, found)
                if bare is not None and bare.hypothesis.effects != names:
                    # What it had was the noise of another fit: nothing of its own is left.
                    del self.fits[names]

    def fit_together(self) -> None:
        """Two to four effects at once, from the linear problem about the reducer as stated.

        Play, friction and what comes with them are each as large as the loop: from a fit that has
        taken the loop for one of them there is no way to the others. One of a pair is among those
        that follow most of the loop alone; three, and one more than the best three, are of the best
        sets. All are ranked, and those near the best fitted to their end.
        """
        singles = sorted((n for n in self.fits if len(n) == 1), key=self.score, reverse=True)
        large = {effect for names in singles[: EFFORT.large] for effect in names}
        pairs = combinations(self.setting.variants, 2)
        self.fit_at_once([pair for pair in pairs if not large.isdisjoint(pair)])
        sets = sorted((n for n in self.fits if len(n) > 1), key=self.score, reverse=True)
        best = list(dict.fromkeys(effect for names in sets for effect in names))[: EFFORT.large]
        self.fit_at_once(list(combinations(best, 3)))
        three = max((n for n in self.fits if len(n) == 3), key=self.score, default=())
        self.fit_at_once([(*three, one) for one in best if three and one not in three])
        near = max(self.score(n) for n in self.fits) - EFFORT.settled_room
        ranked = [f for n, f in self.fits.items() if not f.converged and self.score(n) > near]
        self.crew.each((again(fit, fit.noise) for fit in ranked), self.keep_instead)

    def fit_at_once(self, sets: Sequence[tuple[str, ...]]) -> None:
        """Sets of effects in full, those that are ahead in a few forms, and the best in all: the
        linear problem cannot tell forms of what is as large as the loop."""
        self.report("effects together", 0.65)
        seen = self.setting.signatures, self.views[0].screen
        found = (starts_at_once(self.fitter, *seen, names) for names in sets)
        starts = [forms for forms in found if forms]
        scores = self.scores_from([forms[:1] for forms in starts])
        for first, last, most in (
            (1, EFFORT.variants, EFFORT.at_once),
            (EFFORT.variants, None, EFFORT.best),
        ):
            ahead = np.argsort(-scores, kind="stable")[:most].tolist()
            more = self.scores_from([starts[i][first:last] for i in ahead])
            scores[ahead] = np.maximum(scores[ahead], more)

    def scores_from(self, starts: Sequence[Sequence[tuple[Hypothesis, Floats]]]) -> Floats:
        """The best score of fits from each of some lists of starts."""
        scores = np.full(len(starts), -np.inf)
        tasks = [(i, ranking(*s, self.setting.plain)) for i, of in enumerate(starts) for s in of]
        places = iter([i for i, _ in tasks])

        def take(fit: Fit | None) -> None:
            self.keep(fit)
            self.report("effects together", 0.65)
            i = next(places)
            scores[i] = max(scores[i], -np.inf if fit is None else self.setting.score(fit))

        self.crew.each([task for _, task in tasks], take)
        return scores

    def ask_the_instrument(self) -> None:
        """What is left of the drive as stated and of the best set may be what the instrument does:
        beside few readings a fit that may follow the whole library does not show it. And what the
        instrument seems to do, or loose readings, may be an effect: sets near the best are tried
        without."""
        near = max(self.score(n) for n in self.fits) - EFFORT.modes_room
        c, found = self.fitter.campaign, self.fits.items()
        seen = [f for n, f in found if n and is_odd(f.noise) and self.score(n) > near]
        bare = (again(f, stripped(f.noise, c)) for f in seen)
        self.crew.each(bare, self.keep)
        fits = [self.fits[n] for n in sorted({(), max(self.fits, key=self.score)})]
        # A correlation or outliers may stand in for what the instrument does.
        starts = ((f, n) for f in fits for n in (f.noise, plain(f.noise), c.plain_noise))
        tasks = (again(f, n) for f, s in starts for n in with_an_artefact(self.fitter, f, s))
        self.crew.each(tasks, self.keep)
        # What it does in the best set it may do in a smaller one.
        self.drop(max(self.fits, key=self.score), again=True)

    def share_noise(self) -> None:
        """Sets near the best are tried with the kind of noise that it has: a fit keeps to the kind
        that it began with, so that one may owe its place to that alone, and another one be as far
        behind as that kind is worth."""
        for _ in range(EFFORT.rounds):
            best = max(self.fits, key=self.score)
            fit, c = self.fits[best], self.fitter.campaign
            near = self.score(best) - EFFORT.settled_room
            others = [f for f in self.fits.values() if kind_of(f.noise) != kind_of(fit.noise)]
            tried = [other for other in others if self.setting.score(other) > near]
            bare = replace(stripped(fit.noise, c), torque_arcsec=c.plain_noise.torque_arcsec)
            if kind_of(bare) != kind_of(fit.noise):
                without = again(fit, bare)(self.fitter)
                worth = fit.log_evidence - (without.log_evidence if without else np.nan)
                further = [f for f in others if near >= self.setting.score(f) > near - worth]
                tried += sorted(further, key=self.setting.score)[-EFFORT.sets :]
            tasks = (again(other, fit.noise) for other in tried)
            self.crew.each(tasks, self.keep)
            if max(self.fits, key=self.score) == best:
                return

    def find_modes_of_best(self) -> None:
        """Other modes of the best set, where they were not searched for yet."""
        top = max(self.fits, key=self.score)
        if not self.fits[top].modes_searched:
            self.put([top], [modes_of(self.fits[top])])

    def find_forms(self) -> None:
        """Other shapes of the singles near the best, as with another noise another one is best; and
        sets with a rarer form in the usual one."""
        near = self.near_best()
        alone = [names for names in near if len(names) == 1]
        self.put(alone, [shapes_of(self.fits[names]) for names in alone])
        usual = [task for n in near for task in in_usual_forms(self.fitter, self.fits[n])]
        self.crew.each(usual, self.keep)

    def unnamed(self) -> list[tuple[float, LackOfFit]]:
        """Lack of fit without a name on the best set and in place of some of its effects or of all,
        with log odds, the most probable first."""
        setting, fits = self.setting, self.fits
        best = max(fits, key=self.score)
        null = self.score(())

        def on(base: Names) -> list[LackOfFit]:
            # A family of more numbers follows what any effect does.
            free = len(fits[best].unknowns) - len(fits[base].unknowns)
            few = [f for f in setting.families if f.patterns.shape[1] <= free]
            families = setting.families if base in ((), best) else few
            lacks = lacks_of_fit_on(self.fitter, fits[base], families, setting.flexible)
            return [p for p in lacks if not says_no_more(p, fits[best])]

        bases = sorted(names for names in fits if set(names) <= set(best))
        lacks = side_by_side(self.fitter.campaign, [partial(on, base) for base in bases])
        found = [
            (
                p.log_evidence
                + prior(p.base)
                - setting.price(fits[p.base])
                + float(np.log(ODDS["unknown"] / max(sum(f.share for f in setting.families), 1)))
                - null,
                p,
            )
            for of_base in lacks
            for p in of_base
        ]
        return sorted(found, key=lambda f: -f[0])

    def competition(
        self, unnamed: Sequence[tuple[float, LackOfFit]], rng: np.random.Generator
    ) -> Competition:
        """The outcome, with what chance alone would show."""
        setting, null = self.setting, self.score(())
        log_odds = {names: self.score(names) - null for names in self.fits}
        best = max(log_odds, key=lambda n: log_odds[n])
        screen = Screen(self.fitter.look(setting.null, self.fits[best].noise), setting.wider)
        return Competition(
            self.fitter,
            self.fits,
            log_odds,
            tuple(lack_of_fit for _, lack_of_fit in unnamed),
            tuple(odds for odds, _ in unnamed),
            setting.library,
            setting.names,
            screen.null_of_maximum(setting.weights(setting.wider), EFFORT.replicates, rng),
            setting.flexible,
            setting.families,
        )
