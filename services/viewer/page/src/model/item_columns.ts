import type { ItemIds } from '@gen/corbslam/v1/items_pb';

/** Calls back with slot and number of each item of two columns; slot 0 ("none") is left out. */
export function forEachItem(
  ids: ItemIds | undefined,
  callback: (slot: number, index: number, position: number) => void,
): void {
  if (!ids) return;
  const { slots, indexDeltas } = ids;
  let index = 0;
  for (let i = 0; i < indexDeltas.length; i++) {
    index += Number(indexDeltas[i]);
    const slot = slots.length > 0 ? slots[i] : 1;
    if (slot > 0) callback(slot, index, i);
  }
}
