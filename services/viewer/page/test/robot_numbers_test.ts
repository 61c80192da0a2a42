import assert from 'node:assert/strict';
import test from 'node:test';
import { categoryColour } from '../src/model/palette';
import { numberRobots } from '../src/model/robot_numbers';

test('robots have the same number whatever order they came in', () => {
  const names = ['alpha', 'bravo', 'charlie', 'delta', 'echo', 'foxtrot', 'golf', 'hotel'];
  const numbers = numberRobots(names);
  assert.deepEqual([...numbers.values()].sort(), [0, 1, 2, 3, 4, 5, 6, 7]);
  assert.deepEqual(numberRobots([...names].reverse()), numbers);
  assert.equal(numberRobots(['bravo']).get('bravo'), numbers.get('bravo'));
});

test('numbers in names count', () => {
  const numbers = numberRobots(['robot2', 'robot10', 'robot3']);
  assert.deepEqual(['robot2', 'robot3', 'robot10'].map((name) => numbers.get(name)), [2, 3, 4]);
});

test('any name has a number, also where there are more than colours', () => {
  const names = ['', '-', '😀', 'Ünal', ...Array.from({ length: 20 }, (_, i) => `x${i}`)];
  const numbers = [...numberRobots(names).values()];
  assert.equal(new Set(numbers).size, names.length);
  assert.deepEqual(numbers.toSorted((a, b) => a - b), [...names.keys()]);
});

test('twenty robots have twenty colours, in either theme', () => {
  for (const theme of ['light', 'dark'] as const) {
    const colours = Array.from({ length: 20 }, (_, number) => categoryColour(theme, number));
    assert.equal(new Set(colours).size, 20);
    for (const colour of colours) assert.match(colour, /^#[0-9a-f]{6}$/);
  }
});
