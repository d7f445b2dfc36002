/** The page's keys and gestures: what each does, and the sheet that lists them. */
import { ONLY_STEINER } from './costs.ts';
import type { History } from './history.ts';
import type { Parts } from './parts.ts';
import { TOOLS } from './points_part.ts';
import { shortcuts } from './shortcuts.ts';
import { byCost } from './state.ts';

export interface KeyActions extends Parts {
  readonly steps: History;
  theme(): void;
  fold(): void;
  nextUp(): void;
  /** Tells something that is soon forgotten. */
  say(text: string): void;
  escape(): void;
}

/** Where fingers point there may be keys all the same, but no clicks. */
const byPointer = () =>
  matchMedia('(pointer: coarse)').matches
    ? [
        { keys: 'Tap', does: 'Place what the tool says' },
        { keys: 'Drag', does: 'Move a point along the surface; with the brush paint; elsewhere turn the view' },
        { keys: 'Pinch', does: 'Nearer and farther; with two fingers shift the view' },
      ]
    : [
        { keys: 'Click', does: 'Place what the tool says' },
        { keys: 'Shift Click', does: 'One more source' },
        { keys: 'Drag', does: 'Move a point along the surface; with the brush paint, with Shift erase; elsewhere turn the view' },
      ];

/** Listens for the keys; the returned function shows the sheet. */
export function pageKeys({ state, results, actions, steps, theme, fold, nextUp, escape, say }: KeyActions): () => void {
  const nextMethod = () => {
    if (byCost(state.value)) return say(ONLY_STEINER);
    const names = results.value.methods.map(({ name }) => name);
    const next = names[(names.indexOf(state.value.method as never) + 1) % names.length];
    if (next) state.set({ method: next });
  };
  const pull = () => {
    if (byCost(state.value)) say('Paths of least cost are not straight');
    else state.set({ refine: !state.value.refine });
  };
  const otherColours = () => {
    const { show, colours } = state.value;
    if (show === 'distance') state.set({ colours: colours === 'turbo' ? 'viridis' : 'turbo' });
    else say('Other colours are for distances: choose Distance');
  };
  const showKeys = shortcuts([
    {
      title: 'Points',
      keys: [
        ...byPointer(),
        ...TOOLS.map(({ value, label }, index) => ({ keys: `${index + 1}`, does: `Tool: ${label}`, run: () => state.set({ tool: value }) })),
        { keys: 'K', does: 'Keep the path in the list', run: actions.keep },
        { keys: 'J', does: 'Close the loop; Enter or a double click, too', run: actions.closeLoop },
        { keys: 'X', does: 'Clear the points', run: actions.clear },
        { keys: 'Ctrl Z', does: 'Undo; with Shift redo' },
      ],
    },
    {
      title: 'View',
      keys: [
        { keys: '← ↑ → ↓', does: 'Turn, with the mesh in focus' },
        { keys: '+ −', does: 'Nearer and farther' },
        { keys: 'Enter', does: 'Place a point at the cross in the middle' },
        { keys: 'F', does: 'All of the mesh', run: actions.fit },
        { keys: 'U', does: 'Another axis up: y, z, x', run: nextUp },
        { keys: 'P', does: 'Fold the panel', run: fold },
        { keys: 'T', does: 'Dark or light', run: theme },
      ],
    },
    {
      title: 'Field',
      keys: [
        { keys: 'C', does: 'Other colours of distances', run: otherColours },
        { keys: '[', does: 'Fewer isolines', run: () => state.set({ lines: Math.max(0, state.value.lines - 4) }) },
        { keys: ']', does: 'More isolines', run: () => state.set({ lines: Math.min(60, state.value.lines + 4) }) },
        { keys: 'E', does: 'Edges of the mesh', run: () => state.set({ edges: !state.value.edges }) },
        { keys: 'L', does: 'Distances along the path', run: () => state.set({ ticks: !state.value.ticks }) },
        { keys: 'R', does: 'Pull the path straight', run: pull },
        { keys: 'M', does: 'Next method', run: nextMethod },
        { keys: 'O', does: 'Open a file', run: actions.open },
        { keys: 'Escape', does: 'Take a drag back; stop what is under way, else close messages', run: escape },
        { keys: '?', does: 'This sheet', run: () => showKeys() },
      ],
    },
  ]);
  undoKeys(steps);
  return showKeys;
}

/** Ctrl Z, with Shift or as Ctrl Y the other way; where one types they are the text's own. */
function undoKeys(steps: History): void {
  addEventListener('keydown', (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || (event.target instanceof HTMLInputElement && event.target.type === 'text')) return;
    if (document.querySelector('dialog[open]')) return; // what is undone would be behind it
    const key = event.key.toLowerCase();
    if (key !== 'z' && key !== 'y') return;
    event.preventDefault();
    if (key === 'y' || event.shiftKey) steps.redo();
    else steps.undo();
  });
}
