/** What programs say to each other when something fails, and what it means to a person. */
const MEANINGS: [RegExp, string][] = [
  [/connection refused/i, 'nothing listens at its address'],
  [/no route to host|network is unreachable|host is down/i, 'the network does not lead there'],
  [/name resolution|dns|could not resolve|unknown host|getaddrinfo/i, 'its name leads nowhere'],
  [/deadline exceeded|timed? ?out|timeout/i, 'it takes too long to answer'],
  [/certificate|handshake|ssl|tls/i, 'the two do not accept each other’s certificates'],
  [/socket closed|connection reset|broken pipe|goaway|stream removed|rst_stream|transport/i, 'the connection broke'],
  [/failed to connect to all addresses|channel is in state|unavailable/i, 'it can’t be reached'],
  [/unimplemented|method not found|unknown service/i, 'what answers there is another program, or an older version'],
];
/** "GetMission: ", "UNAVAILABLE: ", "14: " before the words. */
const PREFIX = /^(?:(?:[A-Z][a-z]+){2,}|[A-Z]+(?:_[A-Z]+)*|\d{1,2}):\s*/;
/** Where words of gRPC are, rather than ours. */
const RAW = /ipv[46]:|last error|grpc|failed to connect|\bUNKNOWN\b|errno|socket closed|rst_stream|goaway|deadline exceeded|connection re(?:fused|set)|unimplemented|handshake|stream removed|channel is in state|broken pipe/i;

/** A failure as a person reads it; what is in words already stays, without the call's name before it. */
export function plainText(told: string): string {
  let words = told.trim();
  while (PREFIX.test(words)) words = words.replace(PREFIX, '');
  const raw = words === '' ? told : words;
  if (words !== '' && !RAW.test(raw)) return words;
  return MEANINGS.find(([pattern]) => pattern.test(raw))?.[1] ?? (words || 'it does not say why');
}
