/** The buttons at the panel's head: undo and redo, dark or light, the sheet of keys. */
import type { History } from './history.ts';
import type { PanelButton } from './panel.ts';

export function headButtons(steps: History, theme: () => void, showKeys: () => void): PanelButton[] {
  const follow = (can: () => boolean) => (enable: (on: boolean) => void) => {
    const tell = () => enable(can());
    steps.listen(tell);
    tell();
  };
  return [
    { label: 'Undo', icon: 'M7 5L3.5 8.5L7 12M4 8.5h7.5a4 4 0 0 1 0 8H9', run: () => steps.undo(), follow: follow(() => steps.canUndo) },
    { label: 'Redo', icon: 'M13 5l3.5 3.5L13 12M16 8.5H8.5a4 4 0 0 0 0 8H11', run: () => steps.redo(), follow: follow(() => steps.canRedo) },
    { label: 'Dark or light', icon: 'M10 3a7 7 0 1 0 7 7a5.5 5.5 0 0 1-7-7', run: theme },
    { label: 'Keys and gestures', icon: 'M7.5 7.5a2.5 2.5 0 1 1 3.6 2.2c-.8.4-1.1.9-1.1 1.8M10 14.5v.5', run: showKeys },
  ];
}
