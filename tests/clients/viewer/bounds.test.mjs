// What a page keeps in its link and for undo does not grow without an end, whatever is painted.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { viewerModule } from './modules.mjs';

const { linkOf, stateIn, tooMuchPainted } = await viewerModule('link.ts');
const { History } = await viewerModule('history.ts');
const { START, Store } = await viewerModule('state.ts');

const SPOT = { face: 7, bary: [0.25, 0.25, 0.5] };
/** So many faces of which no two follow each other. */
const speckled = (count) => ({ ...START.painted, faces: Array.from({ length: count }, (_, index) => [2 * index, 2 * index]) });
const kept = (painted) => ({ from: SPOT, via: [], to: SPOT, method: 'exact', pointsPerEdge: null, refine: true, painted });

test('a link has the kept paths that it has room for, as they are', () => {
  const few = { ...START, measures: Array.from({ length: 50 }, () => kept(speckled(100))) };
  assert.ok(!tooMuchPainted(few));
  assert.equal(stateIn(linkOf(few)).measures.length, 50);
  const many = { ...START, measures: Array.from({ length: 50 }, () => kept(speckled(4000))) };
  assert.ok(tooMuchPainted(many));
  const link = linkOf(many);
  assert.ok(link.length < 350_000, `${link.length}`);
  const { measures } = stateIn(link);
  assert.ok(measures.length > 5 && measures.length < 50);
  for (const measure of measures) assert.deepEqual(measure, many.measures[0]);
  // Without its painting it would be another path.
  const one = { ...START, measures: [kept(speckled(100_000)), kept(speckled(3))] };
  assert.ok(tooMuchPainted(one));
  assert.deepEqual(stateIn(linkOf(one)).measures, [one.measures[1]]);
});

test('steps back are two hundred, or fewer where much is painted', () => {
  const stepsOf = (paint) => {
    const state = new Store({ ...START, mesh: 'a' });
    const steps = new History(state);
    for (let index = 0; index < 250; index++) state.set(paint(index));
    let count = 0;
    for (; steps.canUndo; count++) steps.undo();
    return count;
  };
  assert.equal(stepsOf((face) => ({ painted: { ...START.painted, faces: [[face, face]] } })), 200);
  const much = speckled(200_000);
  assert.equal(stepsOf((index) => ({ painted: { ...much, as: index % 2 ? 'forbid' : 'within' } })), 5);
  // Steps that share one painting count it once.
  assert.equal(stepsOf((face) => ({ painted: much, target: { ...SPOT, face } })), 200);
});
